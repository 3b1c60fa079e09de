// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <optional>

#include "common/odometry_buffer.hpp"
#include "common/pose2.hpp"
#include "common/sensor_message.hpp"
#include "common/time.hpp"
#include "visual_slam/body_pose.hpp"
#include "visual_slam/ekf.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// How base_link moves between images: by the wheel odometry or, where the motion model uses none, by what the filter
/// itself believes.
class DeadReckoning {
 public:
  explicit DeadReckoning(const VisualSlamOptions& options)
      : by_wheels_(options.motion.model == MotionModelKind::kOdometry),
        odometry_(common::from_seconds(
            std::max(kLeastMemory, options.image_clock.memory + options.image_clock.most_offset))) {}

  bool by_wheels() const { return by_wheels_; }
  void add(const common::WheelOdometry& odometry) { odometry_.add(odometry); }
  /// Whether the motion until `stamp` is known.
  bool reaches(common::Nanoseconds stamp) const { return !by_wheels_ || odometry_.pose_at(stamp).has_value(); }
  /// Moves the filter on to `stamp`, which must be within reach, from `since`; without that it begins there.
  void predict(Ekf& filter, std::optional<common::Nanoseconds> since, common::Nanoseconds stamp);
  /// The filter was corrected: without wheels the robot moves as it says now.
  void corrected(const Ekf& filter);
  /// The estimate at the newest image is made: without wheels base_link is where the filter says.
  void estimated(const Ekf& filter);

  /// T_odom_base at the newest image; without wheels, T_map_base.
  const common::Pose2& pose() const { return pose_; }
  const BodyTwist& twist() const { return twist_; }

 private:
  static constexpr double kLeastMemory = 10.0;  // [s]; images kept may be as old as the memory of their clock

  bool by_wheels_;
  common::OdometryBuffer odometry_;
  common::Pose2 pose_;
  BodyTwist twist_;
};

}  // namespace slamfuse::visual_slam
