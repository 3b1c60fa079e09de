// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/map_search.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr double kCarriedAway = 16.3;  // squared standard deviations, by which one pose in 1000 misses by chance

bool is_elsewhere(const Ekf& filter, const Relocalisation& found) {
  return filter.distance_to(found.pose, found.covariance) > kCarriedAway;
}

}  // namespace

MapSearch::MapSearch(const VisualSlamOptions& options, std::uint64_t seed)
    : options_(options.relocalisation),
      place_(options.relocalisation, seed),
      loops_(options.loop, options.relocalisation, seed) {}

void MapSearch::doubt_pose() {
  pose_doubted_ = true;
  place_.end();
}

void MapSearch::pose_was_set() {
  pose_doubted_ = false;
  place_.end();
}

void MapSearch::clear() {
  place_.end();
  loops_.clear();
  pose_doubted_ = false;
}

std::optional<MapSearch::Found> MapSearch::find_place(const Ekf& filter, const PlaceSearch::Map& map,
                                                      const Glimpse& glimpse, const cv::Mat& picture,
                                                      const Features& features) {
  const auto place = place_.look(map, glimpse, picture, features(options_.features));
  if (!place) return std::nullopt;
  const bool elsewhere = pose_doubted_ || is_elsewhere(filter, *place);
  pose_doubted_ = false;
  placed_ = true;
  return Found{*place, elsewhere, place_.since()};
}

std::optional<Relocalisation> MapSearch::find_loop(const Ekf& filter, const LoopSearch::OldMap& map,
                                                   const Glimpse& glimpse, const cv::Mat& picture,
                                                   const Features& features) {
  if (!loops_.is_due(glimpse.stamp)) return std::nullopt;
  const auto found = loops_.look(map, glimpse, filter.pose(), picture, features(options_.features));
  // The next search must not meet the map this pose is about to move.
  if (!found || !is_elsewhere(filter, *found)) return std::nullopt;
  loops_.clear();
  return found;
}

}  // namespace slamfuse::visual_slam
