// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "visual_slam/camera_tracks.hpp"
#include "visual_slam/feature_selection.hpp"
#include "visual_slam/front_end.hpp"
#include "visual_slam/options.hpp"
#include "visual_slam/turn_search.hpp"

namespace slamfuse::visual_slam {

/// Sees to it that each camera has features to follow: those of its previous picture, and new ones where these become
/// few, in the regions worth having (seed 001).
class FeatureSupply {
 public:
  /// A feature nobody has seen before.
  struct NewFeature {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    std::string object;  ///< the known object it is on, if any
  };

  FeatureSupply(const VisualSlamOptions& options, FeatureSelection selection, std::size_t cameras);

  /// Takes the next picture of a camera and finds in it features of the previous one. Where nobody has told of turns,
  /// the one that was not foreseen is looked for first (TurnSearch).
  std::vector<Track> follow(std::size_t index, const Camera& camera, const cv::Mat& picture,
                            std::vector<ExpectedFeature> expected);
  /// How many features a picture in which so many are found could do with; 0 while only a few are missing.
  int missing(std::size_t found) const;
  /// New features of the picture that was followed last, away from `tracks`; none while only a few are missing.
  std::vector<NewFeature> refill(std::size_t index, const cv::Mat& picture, const std::vector<Track>& tracks);
  /// Any features of the picture that was followed last, at most so many.
  std::vector<Eigen::Vector2d> any(std::size_t index, int wanted);

 private:
  FrontEndOptions front_end_options_;
  int least_features_;
  bool turns_are_told_;
  FeatureSelection selection_;
  std::unique_ptr<FrontEnd> front_end_;
  TurnSearch turn_search_;
};

}  // namespace slamfuse::visual_slam
