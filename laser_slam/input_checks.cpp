// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/input_checks.hpp"

#include <cmath>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include "laser_slam/grid_map.hpp"

namespace slamfuse::laser_slam {

common::Result<void> check_set_pose(const common::SetPose& command, const Eigen::Matrix3d& floor) {
  if (!command.pose.is_finite() || std::hypot(command.pose.x, command.pose.y) > GridMap::kFarthest) {
    return common::failed(fmt::format("the position is ({}, {}), the heading {}; allowed is up to {} m from the origin",
                                      command.pose.x, command.pose.y, command.pose.theta, GridMap::kFarthest));
  }
  const Eigen::Matrix3d covariance = command.covariance + floor;
  if (!covariance.allFinite() || covariance.llt().info() != Eigen::Success) {
    return common::failed("the covariance is not finite or not positive semidefinite");
  }
  const double spread = std::sqrt(covariance.diagonal().head<2>().maxCoeff());
  if (spread > GridMap::kFarthest) {
    return common::failed(
        fmt::format("the position's standard deviation is {} m, allowed is up to {} m", spread, GridMap::kFarthest));
  }
  return {};
}

common::Result<void> check_odometry(const common::WheelOdometry& odometry) {
  if (!odometry.pose.is_finite()) return common::failed("odometry pose is not finite");
  const double distance = std::hypot(odometry.pose.x, odometry.pose.y);
  if (distance > kFarthestOdometry) {
    return common::failed(
        fmt::format("odometry is {} m from its origin, allowed are up to {}", distance, kFarthestOdometry));
  }
  return {};
}

}  // namespace slamfuse::laser_slam
