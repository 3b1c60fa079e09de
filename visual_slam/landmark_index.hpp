// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "common/landmark.hpp"
#include "visual_slam/descriptor_matcher.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// A landmark whose place is known.
struct PlacedLandmark {
  std::int64_t id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< in the map
  double variance = 0.0;                               ///< mean of the three coordinates' variances
};

/// A feature of a picture that looks like a landmark.
struct LandmarkMatch {
  int feature = 0;   ///< row of the descriptors asked for
  int landmark = 0;  ///< index into LandmarkIndex::landmarks()
};

/// The feature database (seed 000 section II D): all landmarks of a map by how they looked, to be searched without
/// knowing where the camera is. A picture of the map at one moment: it is built anew when the map has changed.
class LandmarkIndex {
 public:
  LandmarkIndex(const RelocalisationOptions& options, std::span<const common::Landmark> landmarks);

  bool empty() const { return landmarks_.empty(); }
  const std::vector<PlacedLandmark>& landmarks() const { return landmarks_; }
  /// For the descriptors of a picture's features (a row each) the landmarks they look like: near enough, and nearer by
  /// the ratio test than the next landmark at another place. Deterministic.
  std::vector<LandmarkMatch> match(const cv::Mat& descriptors) const;

 private:
  RelocalisationOptions options_;
  std::vector<PlacedLandmark> landmarks_;
  std::vector<int> landmark_of_;  // for each of views_
  DescriptorIndex views_;         // those that have a descriptor
};

}  // namespace slamfuse::visual_slam
