// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/descriptor_matcher.hpp"

#include <algorithm>
#include <tuple>

namespace slamfuse::visual_slam {
namespace {

constexpr std::uint64_t kSeed = 1;       // of FLANN's random trees
constexpr int kTrees = 4;                // k-d trees searched side by side
constexpr int kChecks = 64;              // leaves looked at
constexpr int kTables = 8;               // hash tables of LSH
constexpr int kKeyBits = 14;             // of a hash
constexpr int kProbeLevel = 1;           // neighbouring buckets looked at, too
constexpr float kFarthestSift = 300.0F;  // OpenCV's SIFT descriptors are about 512 long
constexpr float kFarthestOrb = 64.0F;    // bits of 256
constexpr double kSamePlace = 3.0;       // [px]

/// OpenCV's random numbers of this thread start anew, and go on as if nothing had been drawn.
class ScopedSeed {
 public:
  explicit ScopedSeed(std::uint64_t seed) : before_(cv::theRNG().state) { cv::theRNG().state = seed; }
  ~ScopedSeed() { cv::theRNG().state = before_; }
  ScopedSeed(const ScopedSeed&) = delete;
  ScopedSeed& operator=(const ScopedSeed&) = delete;

 private:
  std::uint64_t before_;
};

cv::Ptr<cv::DescriptorMatcher> make_matcher(FeatureKind kind, DescriptorSearch search) {
  const bool binary = kind == FeatureKind::kOrb;
  if (search == DescriptorSearch::kComplete) {
    return cv::makePtr<cv::BFMatcher>(binary ? static_cast<int>(cv::NORM_HAMMING) : static_cast<int>(cv::NORM_L2));
  }
  if (binary) {
    return cv::makePtr<cv::FlannBasedMatcher>(cv::makePtr<cv::flann::LshIndexParams>(kTables, kKeyBits, kProbeLevel));
  }
  return cv::makePtr<cv::FlannBasedMatcher>(cv::makePtr<cv::flann::KDTreeIndexParams>(kTrees),
                                            cv::makePtr<cv::flann::SearchParams>(kChecks));
}

}  // namespace

DescriptorIndex::DescriptorIndex(FeatureKind kind, DescriptorSearch search, const cv::Mat& descriptors)
    : descriptors_(descriptors), search_(search), matcher_(make_matcher(kind, search)) {
  if (descriptors.empty() || search == DescriptorSearch::kComplete) return;
  const ScopedSeed seed(kSeed);
  matcher_->add(std::vector<cv::Mat>{descriptors});
  matcher_->train();
}

std::vector<std::vector<Neighbour>> DescriptorIndex::nearest(const cv::Mat& queries, int count,
                                                             const cv::Mat& allowed) const {
  std::vector<std::vector<Neighbour>> result(static_cast<std::size_t>(queries.rows));
  if (queries.empty() || descriptors_.empty()) return result;
  count = std::min(count, descriptors_.rows);
  std::vector<std::vector<cv::DMatch>> matches;
  if (search_ == DescriptorSearch::kComplete) {
    matcher_->knnMatch(queries, descriptors_, matches, count, allowed);
  } else {
    const ScopedSeed seed(kSeed);
    matcher_->knnMatch(queries, matches, count);
  }
  for (const std::vector<cv::DMatch>& of_one : matches) {
    for (const cv::DMatch& match : of_one) {
      if (!allowed.empty() && allowed.at<unsigned char>(match.queryIdx, match.trainIdx) == 0) continue;
      result[static_cast<std::size_t>(match.queryIdx)].push_back({match.trainIdx, match.distance});
    }
  }
  for (std::vector<Neighbour>& neighbours : result) {
    std::sort(neighbours.begin(), neighbours.end(), [](const Neighbour& a, const Neighbour& b) {
      return std::tie(a.distance, a.index) < std::tie(b.distance, b.index);
    });
  }
  return result;
}

std::optional<Neighbour> clear_match(FeatureKind kind, double ratio, const std::vector<Neighbour>& neighbours,
                                     const std::vector<cv::KeyPoint>& keypoints) {
  if (neighbours.empty()) return std::nullopt;
  const Neighbour& best = neighbours.front();
  if (best.distance > (kind == FeatureKind::kOrb ? kFarthestOrb : kFarthestSift)) return std::nullopt;
  const cv::Point2f place = keypoints[static_cast<std::size_t>(best.index)].pt;
  for (const Neighbour& other : neighbours) {
    if (cv::norm(keypoints[static_cast<std::size_t>(other.index)].pt - place) <= kSamePlace) continue;
    if (static_cast<double>(best.distance) > ratio * static_cast<double>(other.distance)) return std::nullopt;
    break;
  }
  return best;
}

}  // namespace slamfuse::visual_slam
