// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "visual_slam/relocaliser.hpp"

namespace slamfuse::visual_slam {

/// A search of the whole map that goes on from image to image until it is ended.
class PlaceSearch {
 public:
  /// The landmarks of the map.
  using Map = std::function<std::vector<common::Landmark>()>;

  PlaceSearch(const RelocalisationOptions& options, std::uint64_t seed)
      : options_(options), relocaliser_(options, seed) {}

  /// Takes the features of the next image. The map is asked for at the first of a search: it must not change until the
  /// end.
  std::optional<Relocalisation> look(const Map& map, const Glimpse& glimpse, const cv::Mat& picture,
                                     std::span<const Eigen::Vector2d> features) {
    if (!index_) {
      index_.emplace(options_, map());
      since_ = glimpse.stamp;
    }
    return relocaliser_.add(*index_, glimpse, picture, features);
  }
  /// The pose is known, or the map has changed.
  void end() {
    index_.reset();
    relocaliser_.clear();
  }
  /// The stamp of the first image of the search.
  common::Nanoseconds since() const { return since_; }
  /// See Relocaliser::best.
  const std::optional<Relocalisation>& best() const { return relocaliser_.best(); }

 private:
  RelocalisationOptions options_;
  Relocaliser relocaliser_;
  std::optional<LandmarkIndex> index_;
  common::Nanoseconds since_ = 0;
};

}  // namespace slamfuse::visual_slam
