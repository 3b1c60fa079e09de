// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "fusion/trajectory_image.hpp"

namespace slamfuse::fusion {

/// The aligned angles of seed 004 (III.B).
struct AlignedAngles {
  double laser = 0.0;           ///< alpha_L [rad] in [0, pi/2)
  double visual = 0.0;          ///< alpha_V [rad] in [0, 2 pi)
  double loss = 0.0;            ///< mean distance of the paired points at these angles [px]
  double runner_up_loss = 0.0;  ///< the same at the best well-separated angles on a grid three times as coarse [px]
};

/// Algorithm 1 of seed 004: over both angles, rotate both images, rescale each to the size of the image, and take the
/// angles with the smallest sum of distances between paired points. Exact: the answer is that of trying every pair of
/// angles on the grid (of equal losses the first), but most pairs are ruled out by a bound.
///
/// Deviations. The printed algorithm rotates by alpha, the result, where the loop's theta is meant. The laser's angle
/// runs over a quarter turn only: the images are square and refilled after the turn, so turning both by 90 degrees
/// changes no distance and the other three quarters are repeats.
///
/// Two pairs of angles are well separated when the rotations between the images they imply (nearest rotation to the
/// affine map) differ by more than `separation` [rad]. `step` [rad] must divide a quarter turn. Returns nothing for
/// empty or unequal inputs or points on a line.
std::optional<AlignedAngles> search_aligned_angles(const Points& laser, const Points& visual, double size, double step,
                                                   double separation);

}  // namespace slamfuse::fusion
