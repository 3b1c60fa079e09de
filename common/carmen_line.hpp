// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/pose2.hpp"
#include "common/time.hpp"

namespace slamfuse::common {

/// Where the beams of a CARMEN laser point and how far it sees.
struct CarmenBeams {
  double angle_min = 0.0;        ///< bearing of the first beam [rad]
  double angle_increment = 0.0;  ///< [rad]
  double range_max = 0.0;        ///< [m]; a reading of this or more saw nothing
  bool operator==(const CarmenBeams&) const = default;
};

/// A laser message of a CARMEN log.
struct CarmenScan {
  std::vector<double> readings;      ///< [m], from right to left, finite and not negative
  std::optional<CarmenBeams> beams;  ///< ROBOTLASER1 tells, FLASER does not
  Pose2 laser_pose;                  ///< in the odometry's frame, or in a corrected one
  Pose2 robot_pose;                  ///< in the odometry's frame
  double forward_speed = 0.0;        ///< [m/s], 0 in a FLASER
  double turn_rate = 0.0;            ///< [rad/s], 0 in a FLASER
  Nanoseconds stamp = 0;             ///< the scan's own (ipc) stamp
};

/// Parses the words of a line (keyword first) that reads `FLASER n ranges... laser_x laser_y laser_theta odom_x odom_y
/// odom_theta ipc_stamp host logger_stamp`. Error (kInvalidInput), without file and line: the word, what is allowed.
Result<CarmenScan> parse_flaser(std::span<const std::string_view> words);

/// The same for `ROBOTLASER1 type start_angle field_of_view resolution maximum_range accuracy remission_mode n
/// ranges... m remissions... laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv forward_safety side_safety
/// turn_axis ipc_stamp host logger_stamp`.
Result<CarmenScan> parse_robotlaser1(std::span<const std::string_view> words);

/// The beams of a FLASER, which tells only how many there are: from -90 deg, 1 deg apart for 180 and 181 readings, 0.5
/// deg for 360 and 361 (SICK LMS), else evenly over 180 deg. `readings` is at least 2.
CarmenBeams flaser_beams(std::size_t readings, double range_max);

}  // namespace slamfuse::common
