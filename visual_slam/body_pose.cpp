// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/body_pose.hpp"

#include <cmath>

namespace slamfuse::visual_slam {
namespace {

constexpr double kSmallTurn = 1e-4;  // [rad] below which series replace quotients

}  // namespace

BodyPose::BodyPose(const common::Pose2& planar) : position(planar.x, planar.y, 0.0) {
  rotation.topLeftCorner<2, 2>() << std::cos(planar.theta), -std::sin(planar.theta), std::sin(planar.theta),
      std::cos(planar.theta);
}

BodyPose::BodyPose(const common::Pose3& spatial)
    : position(spatial.translation), rotation(spatial.rotation.toRotationMatrix()) {}

BodyPose BodyPose::operator*(const BodyPose& other) const {
  BodyPose product;
  product.position = rotation * other.position + position;
  product.rotation = rotation * other.rotation;
  return product;
}

BodyPose BodyPose::inverse() const {
  BodyPose inverse;
  inverse.rotation = rotation.transpose();
  inverse.position = -(inverse.rotation * position);
  return inverse;
}

BodyPose displacement(const BodyTwist& twist, double seconds) {
  const bool planar = twist.linear.z() == 0.0 && twist.angular.head<2>().isZero(0.0);
  if (planar) {
    const Eigen::Vector3d numbers(twist.linear.x(), twist.linear.y(), twist.angular.z());
    return common::exp_se2(numbers * seconds);
  }
  const Eigen::Vector3d turn = twist.angular * seconds;
  return common::Pose3{rotation_exp(0.5 * turn) * Eigen::Vector3d(twist.linear * seconds), rotation_exp(turn)};
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return matrix;
}

Eigen::Quaterniond rotation_exp(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  const double factor = angle < kSmallTurn ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  Eigen::Quaterniond rotation;
  rotation.w() = std::cos(0.5 * angle);
  rotation.vec() = factor * turn;
  return rotation;
}

Eigen::Vector3d rotation_log(const Eigen::Quaterniond& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

Eigen::Matrix3d rotation_left_jacobian(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  const bool small = angle < kSmallTurn;
  const double first = small ? 0.5 : (1.0 - std::cos(angle)) / (angle * angle);
  const double second = small ? 1.0 / 6.0 : (angle - std::sin(angle)) / (angle * angle * angle);
  const Eigen::Matrix3d cross = cross_matrix(turn);
  return Eigen::Matrix3d::Identity() + first * cross + second * cross * cross;
}

}  // namespace slamfuse::visual_slam
