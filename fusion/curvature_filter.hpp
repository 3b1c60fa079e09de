// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "fusion/trajectory_image.hpp"

namespace slamfuse::fusion {

/// Algorithm 2 of seed 004: which of the paired points are kept. Point k+1 is dropped when in either trajectory the
/// interior angle at point k, between the points k-1 and k+1, is below `angle` [rad]: the robot would have turned back
/// on the spot. The first two points are kept.
///
/// Deviations. The printed inequality (3) is reversed against the text, and algorithm 2 lacks a square and tests the
/// angle at k-1; the text counts. After a step shorter than `min_step` [px] there is no direction to compare with, so
/// the next point is kept.
///
/// Returns the indices kept, increasing. Both must be of one length.
std::vector<std::size_t> filter_by_curvature(const Points& laser, const Points& visual, double angle, double min_step);

}  // namespace slamfuse::fusion
