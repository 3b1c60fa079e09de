// SPDX-License-Identifier: BSD-3-Clause
#include "common/pose3.hpp"

#include <cmath>

#include "common/angle.hpp"

namespace slamfuse::common {

Pose3 Pose3::operator*(const Pose3& other) const {
  return {rotation * other.translation + translation, (rotation * other.rotation).normalized()};
}

Pose3 Pose3::inverse() const {
  const Eigen::Quaterniond inverse_rotation = rotation.conjugate();
  return {-(inverse_rotation * translation), inverse_rotation};
}

bool Pose3::is_finite() const { return translation.allFinite() && rotation.coeffs().allFinite(); }

Pose3 to_pose3(const Pose2& pose) {
  return {{pose.x, pose.y, 0.0}, Eigen::Quaterniond(Eigen::AngleAxisd(pose.theta, Eigen::Vector3d::UnitZ()))};
}

Pose2 to_pose2(const Pose3& pose) {
  const Eigen::Vector3d forward = pose.rotation * Eigen::Vector3d::UnitX();
  return {pose.translation.x(), pose.translation.y(), normalize_angle(std::atan2(forward.y(), forward.x()))};
}

Pose3 interpolate(const Pose3& a, const Pose3& b, double fraction) {
  return {a.translation + fraction * (b.translation - a.translation),
          a.rotation.slerp(fraction, b.rotation).normalized()};
}

std::optional<Pose3> pose3_from_matrix(const Eigen::Matrix4d& matrix) {
  constexpr double kTolerance = 1e-3;
  if (!matrix.allFinite() || (matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() > kTolerance) return std::nullopt;
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  if ((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() > kTolerance) return std::nullopt;
  if (rotation.determinant() < 0.0) return std::nullopt;
  return Pose3{matrix.topRightCorner<3, 1>(), Eigen::Quaterniond(rotation).normalized()};
}

}  // namespace slamfuse::common
