// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/klt_front_end.hpp"

#include <algorithm>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "visual_slam/feature_grid.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr int kCornerBlock = 5;          // [px] window of the gradient matrix of a corner
constexpr int kMaxIterations = 20;       // of Lucas-Kanade on one level
constexpr double kConverged = 0.02;      // [px]
constexpr double kMinEigenvalue = 1e-4;  // of the followed window's gradient matrix, as OpenCV normalises it
constexpr double kCornerScale = 1.0;     // cornerMinEigenVal already scales 8-bit pictures to 0..1

cv::Point2f to_point(const Eigen::Vector2d& pixel) {
  return {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
}

/// A corner found, for sorting: strongest first, then by place, so that the order is always the same.
struct Corner {
  float strength;
  int x;
  int y;
  bool operator<(const Corner& other) const {
    if (strength != other.strength) return strength > other.strength;
    return y != other.y ? y < other.y : x < other.x;
  }
};

/// Local maxima of the strength that are strong enough and inside the border.
std::vector<Corner> local_maxima(const cv::Mat& strength, const cv::Mat& region, float threshold, int border) {
  cv::Mat highest;
  cv::dilate(strength, highest, cv::Mat());
  std::vector<Corner> corners;
  for (int y = border; y < strength.rows - border; ++y) {
    const float* values = strength.ptr<float>(y);
    const float* maxima = highest.ptr<float>(y);
    const unsigned char* wanted = region.empty() ? nullptr : region.ptr<unsigned char>(y);
    for (int x = border; x < strength.cols - border; ++x) {
      if (values[x] < threshold || values[x] != maxima[x] || (wanted != nullptr && wanted[x] == 0)) continue;
      corners.push_back({values[x], x, y});
    }
  }
  return corners;
}

}  // namespace

std::vector<FoundFeature> KltFrontEnd::follow(std::size_t camera, const cv::Mat& picture,
                                              std::span<const ExpectedFeature> expected) {
  const cv::Size window(options_.window, options_.window);
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(picture, pyramid, window, options_.pyramid_levels);
  const std::vector<cv::Mat> previous = std::exchange(pyramids_[camera], pyramid);
  std::vector<FoundFeature> found;
  if (previous.empty() || expected.empty()) return found;

  std::vector<cv::Point2f> last, now, back;
  for (const ExpectedFeature& feature : expected) {
    last.push_back(to_point(feature.last));
    now.push_back(to_point(feature.predicted));
  }
  back = last;
  std::vector<unsigned char> forward_ok, backward_ok;
  std::vector<float> error;
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kMaxIterations, kConverged);
  cv::calcOpticalFlowPyrLK(previous, pyramid, last, now, forward_ok, error, window, options_.pyramid_levels, stop,
                           cv::OPTFLOW_USE_INITIAL_FLOW, kMinEigenvalue);
  cv::calcOpticalFlowPyrLK(pyramid, previous, now, back, backward_ok, error, window, options_.pyramid_levels, stop,
                           cv::OPTFLOW_USE_INITIAL_FLOW, kMinEigenvalue);
  const float border = static_cast<float>(options_.border);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const bool inside = now[i].x >= border && now[i].y >= border &&
                        now[i].x <= static_cast<float>(picture.cols - 1) - border &&
                        now[i].y <= static_cast<float>(picture.rows - 1) - border;
    if (!forward_ok[i] || !backward_ok[i] || !inside || cv::norm(back[i] - last[i]) > options_.max_backward_error) {
      continue;
    }
    found.push_back({expected[i].id, {now[i].x, now[i].y}});
  }
  return found;
}

std::vector<Eigen::Vector2d> KltFrontEnd::detect(std::size_t camera, std::span<const Eigen::Vector2d> taken, int wanted,
                                                 const cv::Mat& region) {
  if (wanted <= 0 || pyramids_[camera].empty()) return {};
  const cv::Mat& picture = pyramids_[camera].front();
  cv::Mat strength;
  cv::cornerMinEigenVal(picture, strength, kCornerBlock);
  const int border = std::max(1, static_cast<int>(options_.border));
  std::vector<Corner> corners =
      local_maxima(strength, region, static_cast<float>(options_.min_corner_strength * kCornerScale), border);
  std::sort(corners.begin(), corners.end());

  std::vector<Eigen::Vector2d> candidates;
  for (const Corner& corner : corners) candidates.emplace_back(corner.x, corner.y);
  std::vector<Eigen::Vector2d> chosen;
  for (const std::size_t index : spread_features(candidates, taken, wanted, picture.size(), options_)) {
    chosen.push_back(candidates[index]);
  }
  return chosen;
}

}  // namespace slamfuse::visual_slam
