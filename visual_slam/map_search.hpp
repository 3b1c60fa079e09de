// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "visual_slam/ekf.hpp"
#include "visual_slam/loop_search.hpp"
#include "visual_slam/options.hpp"
#include "visual_slam/place_search.hpp"

namespace slamfuse::visual_slam {

/// Finds the pose where the filter does not know it, in the whole map, and where it only believes it does, in the old
/// part of the map; and knows how far the filter's pose may be relied on meanwhile.
class MapSearch {
 public:
  /// Features of the picture at hand: asked for when they are needed only.
  using Features = std::function<std::vector<Eigen::Vector2d>(int wanted)>;

  /// A pose found in the whole map.
  struct Found {
    Relocalisation place;
    bool elsewhere = false;         ///< too far from the estimate to be a measurement of it
    common::Nanoseconds since = 0;  ///< the image the search began with
  };

  MapSearch(const VisualSlamOptions& options, std::uint64_t seed);

  /// Whether a pose can be found in the whole map: the poses found are planar, and it may be switched off.
  bool is_possible(const Ekf& filter) const { return options_.enabled && filter.is_planar(); }
  /// Nothing is known of the pose: features are not worth looking for near it.
  bool pose_is_doubted() const { return pose_doubted_; }
  /// Whether the pose was found in the whole map since it was lost.
  bool was_placed() const { return placed_; }

  /// Nothing is known of the pose any more. A search begins anew.
  void doubt_pose();
  /// The pose came from outside.
  void pose_was_set();
  /// The estimate is lost: a pose found before does not count any more.
  void lose() { placed_ = false; }
  /// The pose is known: a search ends.
  void end() { place_.end(); }
  /// The map was forgotten.
  void clear();

  /// Takes the next image of a search of the whole map. What is found is to be put into the filter, and to be believed
  /// when the next image agrees.
  std::optional<Found> find_place(const Ekf& filter, const PlaceSearch::Map& map, const Glimpse& glimpse,
                                  const cv::Mat& picture, const Features& features);
  /// Takes an image while the pose is tracked. Returns the pose an old part of the map (landmarks unseen for a while)
  /// says when the filter cannot believe it though it could be drift.
  std::optional<Relocalisation> find_loop(const Ekf& filter, const LoopSearch::OldMap& map, const Glimpse& glimpse,
                                          const cv::Mat& picture, const Features& features);
  /// The pose is not tracked: what was looked at for loops does not count any more.
  void interrupt_loops() { loops_.clear(); }

 private:
  RelocalisationOptions options_;
  PlaceSearch place_;
  LoopSearch loops_;
  bool placed_ = false;
  bool pose_doubted_ = false;
};

}  // namespace slamfuse::visual_slam
