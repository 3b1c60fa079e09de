// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "fusion/pyramid_filter.hpp"

namespace slamfuse::fusion {

/// The essential matrix between the two trajectory images and the motion taken from it.
struct EssentialMotion {
  Eigen::Matrix3d E =
      Eigen::Matrix3d::Zero();  ///< y_laser^T E y_visual = 0 (eq. 5), y = (x/size - 1/2, y/size - 1/2, 1)
  Eigen::Matrix4d T_ess = Eigen::Matrix4d::Identity();  ///< eq. 6, in pixels: acts on (x, y, 1, 1) of the visual image
};

/// Seed 004, III.E: the essential matrix by the eight-point algorithm, its rotation and translation by singular value
/// decomposition.
///
/// Deviations. The decomposition leaves four motions and no length of the translation. The length is the one that
/// brings the points closest in the image plane, and of the four motions the closest is taken. Since both images lie in
/// the plane z = 1 the matrix is not even determined (any plane has a whole family), so whoever calls must test the
/// motion on pairs that were held out. Returns nothing for fewer than eight pairs.
std::optional<EssentialMotion> estimate_essential_motion(const ImagePairs& pairs, double size);

/// Root mean square distance [px] between the laser image and `T_ess` applied to the visual image, in the image plane.
double image_residual(const ImagePairs& pairs, const Eigen::Matrix4d& T_ess);

}  // namespace slamfuse::fusion
