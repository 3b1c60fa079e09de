// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/loop_search.hpp"

#include <algorithm>
#include <cmath>

#include "common/angle.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr int kImages = 6;  // looked at that count together

RelocalisationOptions slowed_down(RelocalisationOptions options, double interval) {
  options.memory = kImages * interval;
  options.max_images = kImages;
  return options;
}

}  // namespace

LoopSearch::LoopSearch(const LoopOptions& options, const RelocalisationOptions& relocalisation, std::uint64_t seed)
    : options_(options),
      relocalisation_(slowed_down(relocalisation, options.interval)),
      relocaliser_(relocalisation_, seed) {}

bool LoopSearch::is_due(common::Nanoseconds stamp) const {
  return options_.enabled && (!looked_ || stamp - *looked_ >= common::from_seconds(options_.interval));
}

void LoopSearch::clear() {
  relocaliser_.clear();
  index_.reset();
}

bool LoopSearch::could_be_drift(const common::Pose2& estimate, const common::Pose2& found) const {
  const double off = (found.translation() - estimate.translation()).norm();
  const double turn = std::abs(common::to_degrees(common::normalize_angle(found.theta - estimate.theta)));
  return (off > options_.min_drift || turn > options_.min_turn_drift) && off <= options_.max_drift * way_ &&
         turn <= options_.max_turn_drift;
}

std::optional<Relocalisation> LoopSearch::look(const OldMap& map, const Glimpse& glimpse, const common::Pose2& estimate,
                                               const cv::Mat& picture, std::span<const Eigen::Vector2d> features) {
  if (looked_) way_ += (glimpse.odometry.translation() - last_odometry_.translation()).norm();
  last_odometry_ = glimpse.odometry;
  looked_ = glimpse.stamp;
  const common::Nanoseconds age = common::from_seconds(options_.min_age);
  if (!index_ || glimpse.stamp - indexed_ > age) {
    index_.emplace(relocalisation_, map(glimpse.stamp - age));
    indexed_ = glimpse.stamp;
  }
  const std::optional<Relocalisation> found = relocaliser_.add(*index_, glimpse, picture, features);
  if (!found || !could_be_drift(estimate, found->pose)) return std::nullopt;
  return found;
}

}  // namespace slamfuse::visual_slam
