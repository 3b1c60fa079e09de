// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "common/error.hpp"
#include "visual_slam/object_database.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// Where in a picture features are worth having.
struct SelectedRegion {
  cv::Mat mask;  ///< 8 bit, not 0 where features may be; empty: everywhere
  std::vector<FoundObject> objects;

  /// The name of the known object at a pixel; empty where there is none. Of two, the first.
  std::string object_at(const Eigen::Vector2d& pixel) const;
};

/// Seed 001's choice of features: regions that stand out (bottom-up), regions of known objects (top-down), or both
/// merged by OR (section 2.2.3). Deterministic.
class FeatureSelection {
 public:
  /// Errors (kInvalidInput): a strategy with known objects without a usable folder of pictures, see
  /// ObjectDatabase::load.
  static common::Result<FeatureSelection> create(const SelectionOptions& options);

  /// `picture` is 8-bit gray, or BGR where there is colour (known objects are looked for in gray).
  SelectedRegion select(const cv::Mat& picture) const;

 private:
  FeatureSelection(const SelectionOptions& options, std::optional<ObjectDatabase> objects)
      : options_(options), objects_(std::move(objects)) {}

  SelectionOptions options_;
  std::optional<ObjectDatabase> objects_;
};

}  // namespace slamfuse::visual_slam
