// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/features2d.hpp>

#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// The features of a picture, strongest first (equally strong ones by place, so that the order is always the same).
struct Features {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;  ///< a row each: SIFT 128 floats, ORB 32 bytes
};

/// Finds features with descriptors: SIFT (seed 000 section II D) or ORB, both OpenCV's, which split a picture over
/// their threads. What is found does not depend on the number of threads.
class FeatureExtractor {
 public:
  /// At most `most` features a picture: of SIFT the strongest, of ORB the strongest of each part of the picture.
  FeatureExtractor(FeatureKind kind, int most);

  /// `picture` is 8-bit gray.
  Features extract(const cv::Mat& picture) const;

 private:
  FeatureKind kind_;
  int most_;
  cv::Ptr<cv::Feature2D> method_;
};

}  // namespace slamfuse::visual_slam
