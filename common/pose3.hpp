// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/pose2.hpp"

namespace slamfuse::common {

/// A rigid transform or pose in space: an element of SE(3). `T_a_b` maps coordinates in frame b to frame a. Metres; the
/// rotation is a unit quaternion.
struct Pose3 {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();         ///< [m]
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit length

  Pose3 operator*(const Pose3& other) const;
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return rotation * point + translation; }
  Pose3 inverse() const;
  bool is_finite() const;
};

/// The planar pose at height z = 0 in space.
Pose3 to_pose3(const Pose2& pose);
/// Position and yaw of a pose in a z-up frame; roll, pitch and height are dropped.
Pose2 to_pose2(const Pose3& pose);

/// The pose at `fraction` of the way from a (0) to b (1): position linear, rotation about one axis (slerp).
Pose3 interpolate(const Pose3& a, const Pose3& b, double fraction);

/// From a row-major 4x4 homogeneous matrix. Returns nothing when the last row is not (0, 0, 0, 1), the 3x3 part is not
/// a rotation within 1e-3, or a number is not finite. The rotation is re-orthonormalised (printed matrices are
/// rounded).
std::optional<Pose3> pose3_from_matrix(const Eigen::Matrix4d& matrix);

}  // namespace slamfuse::common
