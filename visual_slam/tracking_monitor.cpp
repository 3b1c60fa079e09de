// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/tracking_monitor.hpp"

namespace slamfuse::visual_slam {

common::TrackingState TrackingMonitor::update(common::Nanoseconds stamp, int inliers) {
  if (!started_ || inliers >= options_.min_inliers) {
    confirmed_ = confirmed_ || inliers >= options_.min_inliers;
    started_ = true;
    last_good_ = stamp;
  }
  const double blind = common::to_seconds(stamp - last_good_);
  if (blind > options_.lost_after) {
    state_ = common::TrackingState::kLost;
  } else if (blind > options_.uncertain_after || !confirmed_) {
    state_ = common::TrackingState::kUncertain;
  } else {
    state_ = common::TrackingState::kTracking;
  }
  return state_;
}

void TrackingMonitor::pose_was_set() {
  started_ = false;
  confirmed_ = false;
  state_ = common::TrackingState::kUncertain;
}

}  // namespace slamfuse::visual_slam
