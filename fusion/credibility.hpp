// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>

#include "common/pose_estimate.hpp"

namespace slamfuse::fusion {

/// Takes a half's word for its state, except that a pose which rests on odometry alone, because no feature of its
/// pictures was seen, is no more than UNCERTAIN: a half goes on calling itself TRACKING for some pictures, and a robot
/// that is carried must not be vouched for meanwhile. One picture without a feature says nothing: one camera of two may
/// look at a wall.
class Credibility {
 public:
  /// The state that the half's next estimate may be taken for.
  common::TrackingState of(const common::PoseEstimate& estimate) {
    int& unseen = unseen_in_a_row_[estimate.source];
    unseen = estimate.health.inliers == 0 ? unseen + 1 : 0;
    const bool is_unconfirmed = unseen > 1 && estimate.state == common::TrackingState::kTracking;
    return is_unconfirmed ? common::TrackingState::kUncertain : estimate.state;
  }

 private:
  std::map<common::PoseSource, int> unseen_in_a_row_;
};

}  // namespace slamfuse::fusion
