// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "common/error.hpp"
#include "common/pose2.hpp"
#include "common/sensor_message.hpp"

namespace slamfuse::laser_slam {

/// Notices a sensor, or its driver, that sends one scan again and again with fresh stamps. In a corridor such scans fit
/// the map wherever odometry says the robot is, so nothing else would tell. No working sensor gives the same number for
/// every beam at two places, as long as it has noise, which shows between neighbouring beams: a simulated one without
/// may see the same all along a corridor, and is never called frozen.
class FrozenScan {
 public:
  /// Where odometry stands from now on (T_odom_base).
  void moved_to(const common::Pose2& T_odom_base);
  /// Takes the next scan. Error (kFailed, the reason): it repeats the one before although the wheels have driven. A
  /// robot that stands may see the same twice, and so may one that sees next to nothing.
  common::Result<void> check(const common::LaserScan& scan);

 private:
  std::vector<float> ranges_;  ///< of the last scan that was new
  std::optional<common::Pose2> T_odom_base_;
  std::optional<common::Pose2> seen_from_;  ///< where odometry stood then
};

}  // namespace slamfuse::laser_slam
