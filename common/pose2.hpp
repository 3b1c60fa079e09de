// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace slamfuse::common {

/// A planar rigid transform or pose: an element of SE(2). `T_a_b` maps coordinates in frame b to frame a and is the
/// pose of b in a. Metres and radians; `theta` is kept in (-pi, pi] by every operation here.
struct Pose2 {
  double x = 0.0;      ///< [m]
  double y = 0.0;      ///< [m]
  double theta = 0.0;  ///< [rad]

  /// T_a_c = T_a_b * T_b_c.
  Pose2 operator*(const Pose2& other) const;
  /// The point [m] given in this pose's frame, in the parent frame.
  Eigen::Vector2d operator*(const Eigen::Vector2d& point) const;
  Pose2 inverse() const;
  Eigen::Vector2d translation() const { return {x, y}; }
  Eigen::Matrix2d rotation() const;
  /// (x, y, theta), the order of every 3x3 covariance.
  Eigen::Vector3d vector() const { return {x, y, theta}; }
  /// The 3x3 homogeneous matrix.
  Eigen::Matrix3d matrix() const;
  bool is_finite() const;
};

/// The pose reached by moving along a constant twist (vx, vy, omega) for unit time: the exponential map of SE(2).
Pose2 exp_se2(const Eigen::Vector3d& twist);
/// The inverse of exp_se2 for |theta| < pi (at pi the turn is taken as positive).
Eigen::Vector3d log_se2(const Pose2& pose);

/// The adjoint matrix: maps a twist given in the pose's frame to the parent frame. exp(Ad_T v) = T exp(v) T^-1.
Eigen::Matrix3d adjoint(const Pose2& pose);

/// Jacobians of a * b in the (x, y, theta) coordinates of the result with respect to those of a and of b.
struct ComposeJacobians {
  Eigen::Matrix3d wrt_a;
  Eigen::Matrix3d wrt_b;
};
ComposeJacobians compose_jacobians(const Pose2& a, const Pose2& b);
/// Jacobian of pose.inverse() in (x, y, theta) coordinates.
Eigen::Matrix3d inverse_jacobian(const Pose2& pose);

/// The pose at `fraction` of the way from a (0) to b (1): position linear, heading by the shortest turn. Fractions
/// outside [0, 1] extrapolate.
Pose2 interpolate(const Pose2& a, const Pose2& b, double fraction);

}  // namespace slamfuse::common
