// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "common/landmark.hpp"
#include "visual_slam/front_end.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// A landmark of the map that should be in view though it is not being followed.
struct RecognitionCandidate {
  std::int64_t id = 0;
  Eigen::Vector2d predicted = Eigen::Vector2d::Zero();  ///< pixel
  double radius = 0.0;                                  ///< of the search around it [px]
  Eigen::Vector3d view = Eigen::Vector3d::Zero();       ///< from the optical centre to the landmark, in the map [m]
};

/// Knows how the landmarks of the map look, from several distances and sides, and finds them again in pictures of any
/// camera: active search (Davison; seed 002 section 2.3's "measurement stage") for a small picture of the landmark,
/// scaled to the predicted distance, by normalised correlation.
class LandmarkRecogniser {
 public:
  explicit LandmarkRecogniser(const RecognitionOptions& options) : options_(options) {}

  /// Takes another look at a landmark of known place; kept if no kept view is similar, and then true is returned.
  /// `view` as above.
  bool remember(std::int64_t landmark, const cv::Mat& picture, const Eigen::Vector2d& pixel,
                const Eigen::Vector3d& view);
  /// Says the descriptor of the look that was kept last.
  void describe_last(std::int64_t landmark, std::vector<std::uint8_t> descriptor) {
    looks_.at(landmark).back().descriptor = std::move(descriptor);
  }
  /// All that is known of how a landmark looks, to be kept elsewhere.
  std::vector<common::LandmarkView> views(std::int64_t landmark) const;
  /// Takes it back. Views without a patch of this class's size cannot be looked for and are left out.
  void restore(std::int64_t landmark, std::span<const common::LandmarkView> views);
  void forget(std::int64_t landmark) { looks_.erase(landmark); }
  void clear() { looks_.clear(); }
  bool knows(std::int64_t landmark) const { return looks_.contains(landmark); }

  /// Whether the landmark was seen from a place similar enough to be recognised from here.
  bool comparable(std::int64_t landmark, const Eigen::Vector3d& view) const;
  /// The landmark in the picture near the prediction; empty when it is not there or not clearly.
  std::optional<FoundFeature> find(const cv::Mat& picture, const RecognitionCandidate& candidate) const;
  /// How alike (correlation, -1..1) the picture at a pixel is to the best kept view; empty when none is comparable.
  std::optional<double> likeness(std::int64_t landmark, const cv::Mat& picture, const Eigen::Vector2d& pixel,
                                 const Eigen::Vector3d& view) const;

 private:
  struct Look {
    cv::Mat patch;
    Eigen::Vector3d view;
    std::vector<std::uint8_t> descriptor = {};
  };

  const Look* best_look(std::int64_t landmark, const Eigen::Vector3d& view) const;

  RecognitionOptions options_;
  std::map<std::int64_t, std::vector<Look>> looks_;
};

}  // namespace slamfuse::visual_slam
