// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/descriptor_front_end.hpp"

#include <map>
#include <optional>
#include <utility>

#include "visual_slam/descriptor_matcher.hpp"
#include "visual_slam/feature_grid.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr double kSamePlace = 3.0;  // [px] from a feature's pixel to the keypoint that describes it
constexpr int kNeighbours = 6;      // looked at for each feature

Eigen::Vector2d to_pixel(const cv::KeyPoint& keypoint) {
  return {static_cast<double>(keypoint.pt.x), static_cast<double>(keypoint.pt.y)};
}

/// The keypoint that describes a pixel: the nearest one, if near enough.
std::optional<int> keypoint_at(const Features& features, const Eigen::Vector2d& pixel) {
  std::optional<int> nearest;
  double least = kSamePlace * kSamePlace;
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    const double distance = (to_pixel(features.keypoints[i]) - pixel).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

/// Which keypoints are within `radius` [px] of each query's predicted pixel.
cv::Mat near_prediction(std::span<const ExpectedFeature* const> queries, const Features& features, double radius) {
  cv::Mat allowed(static_cast<int>(queries.size()), static_cast<int>(features.keypoints.size()), CV_8UC1);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    unsigned char* row = allowed.ptr<unsigned char>(static_cast<int>(i));
    for (std::size_t j = 0; j < features.keypoints.size(); ++j) {
      const bool near = (to_pixel(features.keypoints[j]) - queries[i]->predicted).squaredNorm() <= radius * radius;
      row[j] = near ? 255 : 0;
    }
  }
  return allowed;
}

}  // namespace

DescriptorFrontEnd::DescriptorFrontEnd(const FrontEndOptions& options, FeatureKind kind, std::size_t cameras)
    : options_(options), kind_(kind), extractor_(kind, options.keypoints_per_image), newest_(cameras) {}

bool DescriptorFrontEnd::is_inside(const cv::Size& size, const cv::Point2f& pixel) const {
  const float border = static_cast<float>(options_.border);
  return pixel.x >= border && pixel.y >= border && pixel.x <= static_cast<float>(size.width - 1) - border &&
         pixel.y <= static_cast<float>(size.height - 1) - border;
}

std::vector<FoundFeature> DescriptorFrontEnd::follow(std::size_t camera, const cv::Mat& picture,
                                                     std::span<const ExpectedFeature> expected) {
  const Features before = std::move(newest_[camera].features);
  newest_[camera] = {picture.size(), extractor_.extract(picture)};
  const Features& now = newest_[camera].features;

  std::vector<const ExpectedFeature*> queries;
  std::vector<Eigen::Vector2d> offsets;  // from the keypoint to the feature's own pixel
  cv::Mat descriptors;
  for (const ExpectedFeature& feature : expected) {
    const std::optional<int> keypoint = keypoint_at(before, feature.last);
    if (!keypoint) continue;
    queries.push_back(&feature);
    offsets.push_back(feature.last - to_pixel(before.keypoints[static_cast<std::size_t>(*keypoint)]));
    descriptors.push_back(before.descriptors.row(*keypoint));
  }
  const DescriptorIndex index(kind_, options_.search, now.descriptors);
  const auto neighbours =
      index.nearest(descriptors, kNeighbours, near_prediction(queries, now, options_.search_radius));

  struct Claim {
    std::size_t query;
    float distance;
  };
  std::map<int, Claim> claims;  // by keypoint: the query it fits best
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const std::optional<Neighbour> match = clear_match(kind_, options_.match_ratio, neighbours[i], now.keypoints);
    if (!match || !is_inside(picture.size(), now.keypoints[static_cast<std::size_t>(match->index)].pt)) continue;
    const auto [claim, is_new] = claims.try_emplace(match->index, Claim{i, match->distance});
    if (!is_new && match->distance < claim->second.distance) claim->second = {i, match->distance};
  }
  std::map<std::size_t, int> by_query;  // in the order expected
  for (const auto& [keypoint, claim] : claims) by_query.emplace(claim.query, keypoint);
  std::vector<FoundFeature> found;
  for (const auto& [query, keypoint] : by_query) {
    found.push_back({queries[query]->id, to_pixel(now.keypoints[static_cast<std::size_t>(keypoint)]) + offsets[query]});
  }
  return found;
}

std::vector<Eigen::Vector2d> DescriptorFrontEnd::detect(std::size_t camera, std::span<const Eigen::Vector2d> taken,
                                                        int wanted, const cv::Mat& region) {
  const Picture& picture = newest_[camera];
  std::vector<Eigen::Vector2d> candidates;
  for (const cv::KeyPoint& keypoint : picture.features.keypoints) {
    if (!is_inside(picture.size, keypoint.pt)) continue;
    if (!region.empty() && region.at<unsigned char>(cv::Point(keypoint.pt)) == 0) continue;
    candidates.push_back(to_pixel(keypoint));
  }
  std::vector<Eigen::Vector2d> chosen;
  for (const std::size_t index : spread_features(candidates, taken, wanted, picture.size, options_)) {
    chosen.push_back(candidates[index]);
  }
  return chosen;
}

}  // namespace slamfuse::visual_slam
