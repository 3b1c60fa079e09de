// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "common/similarity2.hpp"

namespace slamfuse::fusion {

/// An invertible affine map of the plane, p -> linear * p + translation, that keeps the sense of turning (determinant >
/// 0). From the visual map frame to the laser map frame wherever this module names no other frames.
struct PlanarAffine {
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();
  Eigen::Vector2d translation = Eigen::Vector2d::Zero();  ///< [m]

  Eigen::Vector2d operator*(const Eigen::Vector2d& point) const { return linear * point + translation; }
  PlanarAffine operator*(const PlanarAffine& other) const;
  PlanarAffine inverse() const;
  /// The 3x3 homogeneous matrix.
  Eigen::Matrix3d matrix() const;
  bool is_finite() const;
};

PlanarAffine to_affine(const common::Similarity2& similarity);

/// An affine map taken apart. The rotation is the one nearest to the linear part (polar decomposition), so it is the
/// true rotation both when the source's axes and when the target's axes are stretched.
struct AffineParts {
  double rotation = 0.0;  ///< [rad] in (-pi, pi]
  /// Stretch along x and y. Of the source's (visual) axes if the map is nearer to "stretch, then rotate", of the
  /// target's (laser) axes if it is nearer to "rotate, then stretch".
  Eigen::Vector2d scale = Eigen::Vector2d::Ones();
  bool scale_along_target_axes = false;  ///< which of the two it was
  double mean_scale = 1.0;               ///< square root of the determinant, what heights are multiplied with
};
AffineParts take_apart(const PlanarAffine& affine);

}  // namespace slamfuse::fusion
