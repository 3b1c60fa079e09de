// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/pose_estimate.hpp"
#include "common/time.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// Says from the accepted features of the images whether the camera still knows where it is. An image with enough of
/// them is good; without a good image for a while the estimate is the wheel odometry's alone, uncertain and then lost.
class TrackingMonitor {
 public:
  explicit TrackingMonitor(const TrackingOptions& options) : options_(options) {}

  /// Takes the number of accepted features of the next image and says the state after it.
  common::TrackingState update(common::Nanoseconds stamp, int inliers);
  /// The pose came from outside: uncertain until the next good image.
  void pose_was_set();
  common::TrackingState state() const { return state_; }

 private:
  TrackingOptions options_;
  bool started_ = false;
  bool confirmed_ = true;
  common::Nanoseconds last_good_ = 0;
  common::TrackingState state_ = common::TrackingState::kTracking;
};

}  // namespace slamfuse::visual_slam
