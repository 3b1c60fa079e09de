// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace cv {
class Mat;
}

namespace slamfuse::visual_slam {

/// ORB descriptors (32 bytes) of pixels of a picture, upright because the robot does not roll. Those too near to the
/// border get an empty one.
std::vector<std::vector<std::uint8_t>> describe(const cv::Mat& picture, std::span<const Eigen::Vector2d> pixels);

}  // namespace slamfuse::visual_slam
