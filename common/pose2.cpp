// SPDX-License-Identifier: BSD-3-Clause
#include "common/pose2.hpp"

#include <cmath>

#include "common/angle.hpp"

namespace slamfuse::common {
namespace {

/// Below this turn [rad] the series of sin(t)/t and (1 - cos t)/t are exact to double precision.
constexpr double kSmallTurn = 1e-4;

/// The matrix V of the exponential map, translation = V * (vx, vy): columns (s, c), (-c, s).
struct TurnFactors {
  double s;  ///< sin(t) / t
  double c;  ///< (1 - cos t) / t
};

TurnFactors turn_factors(double turn) {
  if (std::abs(turn) < kSmallTurn) return {1.0 - turn * turn / 6.0, turn / 2.0 - turn * turn * turn / 24.0};
  // 1 - cos t = 2 sin^2(t/2) without the cancellation.
  const double half = std::sin(turn / 2.0);
  return {std::sin(turn) / turn, 2.0 * half * half / turn};
}

}  // namespace

Pose2 Pose2::operator*(const Pose2& other) const {
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  return {x + c * other.x - s * other.y, y + s * other.x + c * other.y, normalize_angle(theta + other.theta)};
}

Eigen::Vector2d Pose2::operator*(const Eigen::Vector2d& point) const { return rotation() * point + translation(); }

Pose2 Pose2::inverse() const {
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  return {-c * x - s * y, s * x - c * y, normalize_angle(-theta)};
}

Eigen::Matrix2d Pose2::rotation() const {
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  return (Eigen::Matrix2d() << c, -s, s, c).finished();
}

Eigen::Matrix3d Pose2::matrix() const {
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  result.topLeftCorner<2, 2>() = rotation();
  result.topRightCorner<2, 1>() = translation();
  return result;
}

bool Pose2::is_finite() const { return std::isfinite(x) && std::isfinite(y) && std::isfinite(theta); }

Pose2 exp_se2(const Eigen::Vector3d& twist) {
  const auto [s, c] = turn_factors(twist.z());
  return {s * twist.x() - c * twist.y(), c * twist.x() + s * twist.y(), normalize_angle(twist.z())};
}

Eigen::Vector3d log_se2(const Pose2& pose) {
  const auto [s, c] = turn_factors(pose.theta);
  const double determinant = s * s + c * c;
  return {(s * pose.x + c * pose.y) / determinant, (-c * pose.x + s * pose.y) / determinant, pose.theta};
}

Eigen::Matrix3d adjoint(const Pose2& pose) {
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  result.topLeftCorner<2, 2>() = pose.rotation();
  result(0, 2) = pose.y;
  result(1, 2) = -pose.x;
  return result;
}

ComposeJacobians compose_jacobians(const Pose2& a, const Pose2& b) {
  const double c = std::cos(a.theta);
  const double s = std::sin(a.theta);
  ComposeJacobians jacobians{Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()};
  jacobians.wrt_a(0, 2) = -s * b.x - c * b.y;
  jacobians.wrt_a(1, 2) = c * b.x - s * b.y;
  jacobians.wrt_b.topLeftCorner<2, 2>() = a.rotation();
  return jacobians;
}

Eigen::Matrix3d inverse_jacobian(const Pose2& pose) {
  const double c = std::cos(pose.theta);
  const double s = std::sin(pose.theta);
  return (Eigen::Matrix3d() << -c, -s, s * pose.x - c * pose.y, s, -c, c * pose.x + s * pose.y, 0.0, 0.0, -1.0)
      .finished();
}

Pose2 interpolate(const Pose2& a, const Pose2& b, double fraction) {
  return {a.x + fraction * (b.x - a.x), a.y + fraction * (b.y - a.y),
          normalize_angle(a.theta + fraction * angle_difference(b.theta, a.theta))};
}

}  // namespace slamfuse::common
