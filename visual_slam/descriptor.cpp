// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/descriptor.hpp"

#include <opencv2/features2d.hpp>

namespace slamfuse::visual_slam {
namespace {

constexpr float kKeypointSize = 31.0F;  // [px] of ORB's patch

}  // namespace

std::vector<std::vector<std::uint8_t>> describe(const cv::Mat& picture, std::span<const Eigen::Vector2d> pixels) {
  std::vector<std::vector<std::uint8_t>> descriptors(pixels.size());
  std::vector<cv::KeyPoint> keypoints;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    keypoints.emplace_back(static_cast<float>(pixels[i].x()), static_cast<float>(pixels[i].y()), kKeypointSize, 0.0F,
                           1.0F, 0, static_cast<int>(i));
  }
  if (keypoints.empty()) return descriptors;
  cv::Mat rows;
  cv::ORB::create(static_cast<int>(keypoints.size()), 1.2F, 1)->compute(picture, keypoints, rows);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const unsigned char* row = rows.ptr<unsigned char>(static_cast<int>(i));
    descriptors[static_cast<std::size_t>(keypoints[i].class_id)].assign(row, row + rows.cols);
  }
  return descriptors;
}

}  // namespace slamfuse::visual_slam
