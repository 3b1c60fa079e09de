// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/motion_model.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "common/angle.hpp"

namespace slamfuse::laser_slam {
namespace {

constexpr double kShortestInterval = 0.05;  // [s]; stamps of some logs jitter, speeds over less mean nothing

double square(double value) { return value * value; }

}  // namespace

Travel& Travel::operator+=(const common::Pose2& increment) {
  distance += std::hypot(increment.x, increment.y);
  turn += std::abs(increment.theta);
  return *this;
}

Eigen::Matrix3d odometry_covariance(const Travel& travel, const MotionModelOptions& options) {
  const double position = square(options.translation_per_metre * travel.distance) +
                          square(options.translation_per_radian * travel.turn) + square(options.translation_base);
  const double heading = square(options.rotation_per_metre * travel.distance) +
                         square(options.rotation_per_radian * travel.turn) + square(options.rotation_base);
  return Eigen::Vector3d(position, position, heading).asDiagonal();
}

Eigen::Matrix3d prediction_covariance(double seconds, const MotionModelOptions& options) {
  const double interval = std::max(std::abs(seconds), kShortestInterval);
  const double position =
      square(options.predicted_acceleration * interval * interval) + square(options.translation_base);
  const double heading =
      square(options.predicted_turn_acceleration * interval * interval) + square(options.rotation_base);
  return Eigen::Vector3d(position, position, heading).asDiagonal();
}

bool is_jump(const common::Pose2& increment, double seconds, const MotionModelOptions& options) {
  const double interval = std::max(seconds, kShortestInterval);
  return std::hypot(increment.x, increment.y) > options.max_speed * interval ||
         std::abs(increment.theta) > options.max_turn_rate * interval;
}

Eigen::Matrix3d to_parent_frame(const Eigen::Matrix3d& body_covariance, const common::Pose2& pose) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = pose.rotation();
  return turn * body_covariance * turn.transpose();
}

common::Pose2 draw_pose(const common::Pose2& mean, const Eigen::Matrix3d& covariance, RandomStream& random) {
  const Eigen::Matrix3d root = covariance.llt().matrixL();
  const Eigen::Vector3d drawn = mean.vector() + root * random.normal3();
  return {drawn.x(), drawn.y(), common::normalize_angle(drawn.z())};
}

}  // namespace slamfuse::laser_slam
