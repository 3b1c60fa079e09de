// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace slamfuse::laser_slam {

/// Covariance of (x, y, theta) that every estimate gets on top: none claims to be better than a tenth of a cell, 5 mm
/// and 2 mrad.
inline Eigen::Matrix3d pose_floor() {
  constexpr double kPosition = 0.005;  // [m]
  constexpr double kHeading = 0.002;   // [rad]
  return Eigen::Vector3d(kPosition * kPosition, kPosition * kPosition, kHeading * kHeading).asDiagonal();
}

}  // namespace slamfuse::laser_slam
