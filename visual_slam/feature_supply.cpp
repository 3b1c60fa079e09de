// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/feature_supply.hpp"

#include <utility>

namespace slamfuse::visual_slam {
namespace {

constexpr double kRefillShare = 0.15;  // new features are looked for when so many of the wanted are missing

}  // namespace

FeatureSupply::FeatureSupply(const VisualSlamOptions& options, FeatureSelection selection, std::size_t cameras)
    : front_end_options_(options.front_end),
      least_features_(options.selection.least_features),
      turns_are_told_(options.motion.model == MotionModelKind::kOdometry),
      selection_(std::move(selection)),
      front_end_(make_front_end(options.front_end, cameras)),
      turn_search_(options.turn_search, cameras) {}

std::vector<Track> FeatureSupply::follow(std::size_t index, const Camera& camera, const cv::Mat& picture,
                                         std::vector<ExpectedFeature> expected) {
  if (!turns_are_told_) {
    const double turn = turn_search_.find(index, camera, picture, expected);
    for (ExpectedFeature& feature : expected) {
      feature.predicted = turned_pixel(camera, feature.predicted, turn).value_or(feature.predicted);
    }
  }
  std::vector<Track> seen;
  for (const FoundFeature& found : front_end_->follow(index, picture, expected)) {
    seen.push_back({found.id, found.pixel});
  }
  return seen;
}

int FeatureSupply::missing(std::size_t found) const {
  const int missing = front_end_options_.features_per_image - static_cast<int>(found);
  return missing < kRefillShare * front_end_options_.features_per_image ? 0 : missing;
}

std::vector<FeatureSupply::NewFeature> FeatureSupply::refill(std::size_t index, const cv::Mat& picture,
                                                             const std::vector<Track>& tracks) {
  const int wanted = missing(tracks.size());
  if (wanted == 0) return {};
  std::vector<Eigen::Vector2d> taken;
  for (const Track& track : tracks) taken.push_back(track.pixel);
  const SelectedRegion region = selection_.select(picture);
  std::vector<Eigen::Vector2d> found = front_end_->detect(index, taken, wanted, region.mask);
  if (const int few = least_features_ - static_cast<int>(taken.size() + found.size());
      few > 0 && !region.mask.empty()) {
    taken.insert(taken.end(), found.begin(), found.end());
    const std::vector<Eigen::Vector2d> more = front_end_->detect(index, taken, few, cv::Mat());
    found.insert(found.end(), more.begin(), more.end());
  }
  std::vector<NewFeature> fresh;
  for (const Eigen::Vector2d& pixel : found) fresh.push_back({pixel, region.object_at(pixel)});
  return fresh;
}

std::vector<Eigen::Vector2d> FeatureSupply::any(std::size_t index, int wanted) {
  return front_end_->detect(index, {}, wanted, cv::Mat());
}

}  // namespace slamfuse::visual_slam
