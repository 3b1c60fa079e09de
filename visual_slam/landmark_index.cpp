// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/landmark_index.hpp"

#include <algorithm>
#include <tuple>

namespace slamfuse::visual_slam {
namespace {

constexpr int kDescriptorBytes = 32;  // ORB
constexpr int kNeighbours = 8;        // looked at for the ratio test: several views of one landmark are common
constexpr double kSamePlace = 0.15;   // [m] landmarks nearer than this may be the same point entered twice
constexpr int kTables = 8;            // of locality-sensitive hashing
constexpr int kKeyBits = 14;
constexpr int kProbeLevel = 1;
constexpr std::uint64_t kSeed = 1;  // of its random keys

}  // namespace

LandmarkIndex::LandmarkIndex(const RelocalisationOptions& options, std::span<const common::Landmark> landmarks)
    : options_(options) {
  for (const common::Landmark& landmark : landmarks) {
    bool described = false;
    for (const common::LandmarkView& view : landmark.views) {
      if (view.descriptor.size() != kDescriptorBytes) continue;
      descriptors_.push_back(cv::Mat(view.descriptor, true).reshape(1, 1));
      landmark_of_.push_back(static_cast<int>(landmarks_.size()));
      described = true;
    }
    if (described) landmarks_.push_back({landmark.id, landmark.position, landmark.covariance.trace() / 3.0});
  }
  if (options.search == DescriptorSearch::kComplete) {
    matcher_ = cv::makePtr<cv::BFMatcher>(static_cast<int>(cv::NORM_HAMMING));
    return;
  }
  matcher_ = cv::makePtr<cv::FlannBasedMatcher>(cv::makePtr<cv::flann::LshIndexParams>(kTables, kKeyBits, kProbeLevel));
  if (empty()) return;
  cv::theRNG().state = kSeed;
  matcher_->add(std::vector<cv::Mat>{descriptors_});
  matcher_->train();
}

std::vector<LandmarkMatch> LandmarkIndex::match(const cv::Mat& descriptors) const {
  std::vector<LandmarkMatch> result;
  if (empty() || descriptors.empty()) return result;
  const int count = std::min(kNeighbours, descriptors_.rows);
  std::vector<std::vector<cv::DMatch>> neighbours;
  if (options_.search == DescriptorSearch::kComplete) {
    matcher_->knnMatch(descriptors, descriptors_, neighbours, count);
  } else {
    matcher_->knnMatch(descriptors, neighbours, count);
  }
  for (std::vector<cv::DMatch>& of_one : neighbours) {
    if (of_one.empty()) continue;
    std::sort(of_one.begin(), of_one.end(), [](const cv::DMatch& a, const cv::DMatch& b) {
      return std::tie(a.distance, a.trainIdx) < std::tie(b.distance, b.trainIdx);
    });
    const cv::DMatch& best = of_one.front();
    if (best.distance > static_cast<float>(options_.max_distance)) continue;
    const int landmark = landmark_of_[static_cast<std::size_t>(best.trainIdx)];
    const Eigen::Vector3d& place = landmarks_[static_cast<std::size_t>(landmark)].position;
    const auto other = std::find_if(of_one.begin(), of_one.end(), [&](const cv::DMatch& one) {
      const int there = landmark_of_[static_cast<std::size_t>(one.trainIdx)];
      return (landmarks_[static_cast<std::size_t>(there)].position - place).norm() > kSamePlace;
    });
    if (other != of_one.end() &&
        static_cast<double>(best.distance) > options_.ratio * static_cast<double>(other->distance)) {
      continue;
    }
    result.push_back({best.queryIdx, landmark});
  }
  return result;
}

}  // namespace slamfuse::visual_slam
