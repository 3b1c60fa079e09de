// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/feature_extractor.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>
#include <utility>

namespace slamfuse::visual_slam {
namespace {

constexpr int kSiftLayers = 3;          // in an octave, as OpenCV has it
constexpr double kSiftContrast = 0.01;  // OpenCV's 0.04 finds little on walls
constexpr float kOrbScale = 1.2F;
constexpr int kOrbSurplus = 4;  // so many times as many candidates are found as wanted, then thinned by cells
constexpr int kCells = 8;       // columns and rows of cells
constexpr int kOrbLevels = 8;
constexpr int kOrbBorder = 19;        // [px] left alone: half a patch and its turn
constexpr int kOrbPatch = 31;         // [px]
constexpr int kOrbFastThreshold = 4;  // of gray values; OpenCV's 20 finds little on walls

cv::Ptr<cv::Feature2D> make_method(FeatureKind kind, int most) {
  switch (kind) {
    case FeatureKind::kSift:
      break;
    case FeatureKind::kOrb:
      return cv::ORB::create(kOrbSurplus * most, kOrbScale, kOrbLevels, kOrbBorder, 0, 2, cv::ORB::HARRIS_SCORE,
                             kOrbPatch, kOrbFastThreshold);
  }
  return cv::SIFT::create(most, kSiftLayers, kSiftContrast);
}

bool is_stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  const auto key = [](const cv::KeyPoint& point) {
    return std::make_tuple(-point.response, point.pt.y, point.pt.x, point.size, point.angle);
  };
  return key(a) < key(b);
}

/// Leaves `most` keypoints: cells take turns, each giving its strongest, so that blank walls get some, too.
void thin_by_cells(std::vector<cv::KeyPoint>& keypoints, const cv::Size& size, int most) {
  if (keypoints.size() <= static_cast<std::size_t>(most)) return;
  std::sort(keypoints.begin(), keypoints.end(), is_stronger);
  std::array<int, kCells * kCells> given{};
  std::vector<std::pair<int, std::size_t>> turns;  // of each keypoint
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const int column = static_cast<int>(keypoints[i].pt.x) * kCells / size.width;
    const int row = static_cast<int>(keypoints[i].pt.y) * kCells / size.height;
    turns.emplace_back(given[static_cast<std::size_t>(row * kCells + column)]++, i);
  }
  std::sort(turns.begin(), turns.end());
  std::vector<cv::KeyPoint> kept;
  for (std::size_t i = 0; i < static_cast<std::size_t>(most); ++i) kept.push_back(keypoints[turns[i].second]);
  keypoints = std::move(kept);
}

}  // namespace

FeatureExtractor::FeatureExtractor(FeatureKind kind, int most)
    : kind_(kind), most_(most), method_(make_method(kind, most)) {}

Features FeatureExtractor::extract(const cv::Mat& picture) const {
  std::vector<cv::KeyPoint> found;
  cv::Mat rows;
  if (kind_ == FeatureKind::kOrb) {
    method_->detect(picture, found);
    thin_by_cells(found, picture.size(), most_);
    method_->compute(picture, found, rows);
  } else {
    method_->detectAndCompute(picture, cv::noArray(), found, rows);
  }
  std::vector<int> order(found.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return is_stronger(found[static_cast<std::size_t>(a)], found[static_cast<std::size_t>(b)]);
  });
  Features sorted;
  sorted.descriptors.create(rows.rows, rows.cols, rows.type());
  for (std::size_t i = 0; i < order.size(); ++i) {
    sorted.keypoints.push_back(found[static_cast<std::size_t>(order[i])]);
    rows.row(order[i]).copyTo(sorted.descriptors.row(static_cast<int>(i)));
  }
  return sorted;
}

}  // namespace slamfuse::visual_slam
