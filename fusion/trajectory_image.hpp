// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace slamfuse::fusion {

/// Points of a trajectory image [px] or of a trajectory [m].
using Points = std::vector<Eigen::Vector2d>;

/// Where the third coordinate goes.
enum class ImagePlane {
  kLift,  ///< from the floor (z = 0) into the image plane z = 1: T_traj, as eq. 1 prints its third row
  kKeep,  ///< already in the image plane: T_curv
};

/// The matrix of eq. 1 of seed 004 that scales `points` into an image of `size` x `size` pixels, each axis by itself,
/// so that the smallest coordinates become 0 and the largest `size`. Acts on (x, y, z, 1). Returns nothing when the
/// points have no extent along x or y, or one is not finite.
std::optional<Eigen::Matrix4d> trajectory_image_matrix(const Points& points, double size, ImagePlane plane);

/// The matrix of eq. 2, R_AAA: a turn by `angle` [rad] about the image's corner.
Eigen::Matrix4d aligned_angle_rotation(double angle);

/// What a 4x4 matrix does to points of the plane, their third coordinate being that of the image plane throughout.
Points transformed(const Points& points, const Eigen::Matrix4d& matrix);

}  // namespace slamfuse::fusion
