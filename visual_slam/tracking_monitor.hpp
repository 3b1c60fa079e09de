// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/pose_estimate.hpp"
#include "common/time.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// What an image showed of the map.
struct ImageEvidence {
  int expected = 0;       ///< features of the previous image, not new in it, that should be in view
  int inliers = 0;        ///< features accepted
  bool textured = false;  ///< whether the image shows anything to follow at all
  bool doubted = false;   ///< whether the estimate may be wrong though the features fit
};

/// Says from the accepted features of the images whether the camera still knows where it is. An image with enough of
/// them is good. Two kinds of bad images are told apart:
///
/// - The camera sees nothing (dark, white, blurred): the wheel odometry goes on, uncertain and after a while lost.
/// - It sees something, but not what it should, as after the robot was carried away: the odometry is no longer believed
///   either. The estimate is uncertain at once and soon lost, and the map must not grow, until the map is seen again.
class TrackingMonitor {
 public:
  explicit TrackingMonitor(const TrackingOptions& options) : options_(options) {}

  /// Whether the state after an image depends on its being textured, which is dear to find out.
  bool asks_for_texture(const ImageEvidence& image) const;
  /// Takes what the next image showed and says the state after it.
  common::TrackingState update(common::Nanoseconds stamp, const ImageEvidence& image);
  /// Whether what is seen may be entered into the map at the estimated pose.
  bool map_may_grow() const { return !contradicted_; }
  /// The pose came from outside: uncertain until the next good image.
  void pose_was_set();
  /// Nothing is known of the pose: lost until the next good image.
  void lose();
  common::TrackingState state() const { return state_; }

 private:
  bool is_good(const ImageEvidence& image) const { return image.inliers >= options_.min_inliers; }

  TrackingOptions options_;
  bool started_ = false;
  bool confirmed_ = true;
  bool contradicted_ = false;
  common::Nanoseconds last_good_ = 0;
  common::TrackingState state_ = common::TrackingState::kTracking;
};

}  // namespace slamfuse::visual_slam
