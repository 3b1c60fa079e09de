// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// Chooses features spread over a picture of `size` by the options' grid: each round every cell may give its strongest
/// remaining candidate, the emptiest cells first. `candidates` are pixels, strongest first; `taken` are pixels of
/// features there already, which count for their cells and keep others `min_spacing` away. Returns indices of at most
/// `wanted` candidates.
std::vector<std::size_t> spread_features(std::span<const Eigen::Vector2d> candidates,
                                         std::span<const Eigen::Vector2d> taken, int wanted, const cv::Size& size,
                                         const FrontEndOptions& options);

}  // namespace slamfuse::visual_slam
