// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "common/error.hpp"
#include "visual_slam/descriptor_matcher.hpp"
#include "visual_slam/feature_extractor.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// A known object in a picture.
struct FoundObject {
  std::string name;
  std::array<cv::Point2f, 4> outline;  ///< where the corners of its own picture are [px]
};

/// Pictures of known flat objects, such as posters and signs, and how to find them: seed 001 section 2.2.2.
///
/// Features of a picture are matched with those of all objects at once by FLANN and the ratio test, so an object should
/// be there once only; RANSAC (with OpenCV's fixed seed) fits a homography to the matches of each object, which takes
/// the corners of its picture into the image. SIFT or ORB stand in for the seed's SURF, which is not free.
class ObjectDatabase {
 public:
  /// Reads all pictures (JPEG, PNG, PGM, PPM) of a folder; an object's name is its file's name without the ending.
  /// Errors (kInvalidInput), naming the file: no such folder, no picture in it, one that cannot be read or has fewer
  /// features than a match needs, two of one name.
  static common::Result<ObjectDatabase> load(const std::filesystem::path& folder, const SelectionOptions& options);

  /// The objects seen in a picture, in the order of their names.
  std::vector<FoundObject> find(const cv::Mat& picture) const;

  /// In rising order.
  std::vector<std::string> names() const;

 private:
  struct Object {
    std::string name;
    cv::Size size;
  };

  ObjectDatabase(const SelectionOptions& options, std::vector<Object> objects, std::vector<cv::KeyPoint> keypoints,
                 std::vector<std::size_t> owners, const cv::Mat& descriptors);

  SelectionOptions options_;
  FeatureExtractor extractor_;
  std::vector<Object> objects_;
  std::vector<cv::KeyPoint> keypoints_;  // of all objects, each in its own picture
  std::vector<std::size_t> owners_;      // the object of each keypoint
  DescriptorIndex index_;                // of their descriptors
};

/// Whether an outline is what a flat thing can look like: convex, not turned over, and of some size in a picture.
bool is_plausible_outline(const std::array<cv::Point2f, 4>& outline, const cv::Size& picture);

}  // namespace slamfuse::visual_slam
