// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/landmark_index.hpp"

#include <algorithm>

namespace slamfuse::visual_slam {
namespace {

constexpr int kDescriptorBytes = 32;  // ORB
constexpr int kNeighbours = 8;        // looked at for the ratio test: several views of one landmark are common
constexpr double kSamePlace = 0.15;   // [m] landmarks nearer than this may be the same point entered twice

}  // namespace

LandmarkIndex::LandmarkIndex(const RelocalisationOptions& options, std::span<const common::Landmark> landmarks)
    : options_(options) {
  cv::Mat descriptors;  // a row for each view that has one
  for (const common::Landmark& landmark : landmarks) {
    bool described = false;
    for (const common::LandmarkView& view : landmark.views) {
      if (view.descriptor.size() != kDescriptorBytes) continue;
      descriptors.push_back(cv::Mat(view.descriptor, true).reshape(1, 1));
      landmark_of_.push_back(static_cast<int>(landmarks_.size()));
      described = true;
    }
    if (described) landmarks_.push_back({landmark.id, landmark.position, landmark.covariance.trace() / 3.0});
  }
  views_ = DescriptorIndex(FeatureKind::kOrb, options.search, descriptors);
}

std::vector<LandmarkMatch> LandmarkIndex::match(const cv::Mat& descriptors) const {
  std::vector<LandmarkMatch> result;
  const auto neighbours = views_.nearest(descriptors, kNeighbours, {});
  for (std::size_t feature = 0; feature < neighbours.size(); ++feature) {
    if (neighbours[feature].empty()) continue;
    const Neighbour& best = neighbours[feature].front();
    if (best.distance > static_cast<float>(options_.max_distance)) continue;
    const int landmark = landmark_of_[static_cast<std::size_t>(best.index)];
    const Eigen::Vector3d& place = landmarks_[static_cast<std::size_t>(landmark)].position;
    const auto other = std::ranges::find_if(neighbours[feature], [&](const Neighbour& one) {
      const int there = landmark_of_[static_cast<std::size_t>(one.index)];
      return (landmarks_[static_cast<std::size_t>(there)].position - place).norm() > kSamePlace;
    });
    if (other != neighbours[feature].end() &&
        static_cast<double>(best.distance) > options_.ratio * static_cast<double>(other->distance)) {
      continue;
    }
    result.push_back({static_cast<int>(feature), landmark});
  }
  return result;
}

}  // namespace slamfuse::visual_slam
