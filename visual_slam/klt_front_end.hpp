// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "visual_slam/front_end.hpp"

namespace slamfuse::visual_slam {

/// Shi-Tomasi corners (seed 002 section 2.2) followed from picture to picture by pyramidal Lucas-Kanade, which starts
/// at the predicted pixel. A feature must come back to where it was when followed backwards.
class KltFrontEnd : public FrontEnd {
 public:
  KltFrontEnd(const FrontEndOptions& options, std::size_t cameras) : options_(options), pyramids_(cameras) {}

  std::vector<FoundFeature> follow(std::size_t camera, const cv::Mat& picture,
                                   std::span<const ExpectedFeature> expected) override;
  std::vector<Eigen::Vector2d> detect(std::size_t camera, std::span<const Eigen::Vector2d> taken, int wanted,
                                      const cv::Mat& region) override;

 private:
  FrontEndOptions options_;
  std::vector<std::vector<cv::Mat>> pyramids_;  // of the newest picture, by camera
};

}  // namespace slamfuse::visual_slam
