// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <opencv2/features2d.hpp>

#include "visual_slam/feature_extractor.hpp"

namespace slamfuse::visual_slam {

/// A feature that a query descriptor looks like.
struct Neighbour {
  int index = 0;          ///< among the features searched
  float distance = 0.0F;  ///< SIFT: Euclidean; ORB: differing bits
};

/// Finds among descriptors those that others look most like. Deterministic, whatever the number of threads: FLANN's
/// trees are drawn from a fixed seed.
class DescriptorIndex {
 public:
  /// Nothing to search in.
  DescriptorIndex() = default;
  /// `descriptors`: a row each, of that kind; may be empty.
  DescriptorIndex(FeatureKind kind, DescriptorSearch search, const cv::Mat& descriptors);

  /// For each row of `queries` the `count` nearest descriptors, nearest first. `allowed` (queries x descriptors, 8 bit,
  /// 0 is not allowed; empty: all are) says which pairs count: the complete search looks among these alone, FLANN looks
  /// among all and drops the others, so it may return fewer.
  std::vector<std::vector<Neighbour>> nearest(const cv::Mat& queries, int count, const cv::Mat& allowed) const;

 private:
  cv::Mat descriptors_;
  DescriptorSearch search_ = DescriptorSearch::kComplete;
  cv::Ptr<cv::DescriptorMatcher> matcher_;
};

/// The nearest neighbour when it is near enough for features of this kind and nearer by the factor `ratio` than the
/// next one at another place (Lowe's ratio test; SIFT describes some places twice, by two orientations). `keypoints`
/// are those of the descriptors searched.
std::optional<Neighbour> clear_match(FeatureKind kind, double ratio, const std::vector<Neighbour>& neighbours,
                                     const std::vector<cv::KeyPoint>& keypoints);

}  // namespace slamfuse::visual_slam
