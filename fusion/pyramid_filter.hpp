// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fusion/trajectory_image.hpp"

namespace slamfuse::fusion {

/// Paired points of the two images.
struct ImagePairs {
  Points laser;
  Points visual;
};

/// Algorithm 3 of seed 004: every coordinate becomes round(q / ratio) * ratio, and neighbours that have become equal in
/// both images merge into one. The text says "rounded down", the algorithm "round"; rounding to nearest does not shift
/// the image, so it is used (a common shift would cancel between the two images anyway). Both must be of one length.
ImagePairs filter_by_pyramid(const ImagePairs& pairs, double ratio);

}  // namespace slamfuse::fusion
