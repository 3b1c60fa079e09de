// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "common/command.hpp"
#include "common/error.hpp"
#include "common/sensor_message.hpp"

namespace slamfuse::laser_slam {

/// Whether particles can be drawn as a SetPose asks, with `floor` added to its covariance. Errors (kFailed, the
/// reason): a pose that is not finite or farther from the origin than GridMap::kFarthest, a covariance that is none.
common::Result<void> check_set_pose(const common::SetPose& command, const Eigen::Matrix3d& floor);

/// Whether a wheel odometry's pose can be used. Errors (kFailed, the reason): not finite, or farther from its origin
/// than kFarthestOdometry.
common::Result<void> check_odometry(const common::WheelOdometry& odometry);
inline constexpr double kFarthestOdometry = 1e8;  ///< [m]; no map projection counts farther

}  // namespace slamfuse::laser_slam
