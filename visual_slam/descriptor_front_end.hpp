// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "visual_slam/feature_extractor.hpp"
#include "visual_slam/front_end.hpp"

namespace slamfuse::visual_slam {

/// SIFT or ORB features, found anew in every picture and matched by their descriptors from the previous picture to the
/// ones near the predicted pixel (seed 000 section II D, which matches over the whole picture; the prediction leaves
/// out most of what could be mistaken).
class DescriptorFrontEnd : public FrontEnd {
 public:
  DescriptorFrontEnd(const FrontEndOptions& options, FeatureKind kind, std::size_t cameras);

  std::vector<FoundFeature> follow(std::size_t camera, const cv::Mat& picture,
                                   std::span<const ExpectedFeature> expected) override;
  std::vector<Eigen::Vector2d> detect(std::size_t camera, std::span<const Eigen::Vector2d> taken, int wanted,
                                      const cv::Mat& region) override;

 private:
  struct Picture {
    cv::Size size;
    Features features;
  };

  bool is_inside(const cv::Size& size, const cv::Point2f& pixel) const;

  FrontEndOptions options_;
  FeatureKind kind_;
  FeatureExtractor extractor_;
  std::vector<Picture> newest_;  // by camera
};

}  // namespace slamfuse::visual_slam
