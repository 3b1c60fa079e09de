// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "common/pose3.hpp"

namespace slamfuse::visual_slam {

/// Where base_link is (T_map_base), or how it moved, as the projection needs it: position and rotation matrix, planar
/// or not. What is differentiated by a pose is differentiated by its six numbers (e_p, e_r), p = p^ + e_p and
/// R = exp(e_r) R^: the turn is about the map's axes, so a planar pose (x, y, theta) has numbers 0, 1 and 5 of them.
struct BodyPose {
  BodyPose() = default;
  /// A planar pose is a pose.
  BodyPose(const common::Pose2& planar);
  BodyPose(const common::Pose3& spatial);

  /// T_a_c = T_a_b * T_b_c.
  BodyPose operator*(const BodyPose& other) const;
  BodyPose inverse() const;

  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m], or the map's unit
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
};

/// How base_link moves, in its own axes.
struct BodyTwist {
  BodyTwist() = default;
  /// A planar twist (vx, vy, omega) is a twist.
  template <typename Derived>
  BodyTwist(const Eigen::MatrixBase<Derived>& planar)
      : linear(planar[0], planar[1], 0.0), angular(0.0, 0.0, planar[2]) {}
  BodyTwist(const Eigen::Vector3d& velocity, const Eigen::Vector3d& turn_rate) : linear(velocity), angular(turn_rate) {}

  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< [m/s], or the map's unit a second
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< [rad/s]
};

/// What a twist makes of base_link in so many seconds. Planar twists along their arc, others along the chord that is
/// exact to second order.
BodyPose displacement(const BodyTwist& twist, double seconds);

/// The cross product as a matrix: cross_matrix(a) b = a x b.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a);
/// The rotation about the direction of `turn` by its length [rad].
Eigen::Quaterniond rotation_exp(const Eigen::Vector3d& turn);
/// The inverse of rotation_exp for turns of less than pi.
Eigen::Vector3d rotation_log(const Eigen::Quaterniond& rotation);
/// exp(turn + e) = exp(J e) exp(turn) for small e: the left Jacobian of the rotation group.
Eigen::Matrix3d rotation_left_jacobian(const Eigen::Vector3d& turn);

}  // namespace slamfuse::visual_slam
