// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/klt_front_end.hpp"

#include <algorithm>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

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
  std::vector<Eigen::Vector2d> chosen;
  if (wanted <= 0 || pyramids_[camera].empty()) return chosen;
  const cv::Mat& picture = pyramids_[camera].front();
  cv::Mat strength;
  cv::cornerMinEigenVal(picture, strength, kCornerBlock);
  const int border = std::max(1, static_cast<int>(options_.border));
  std::vector<Corner> corners =
      local_maxima(strength, region, static_cast<float>(options_.min_corner_strength * kCornerScale), border);
  std::sort(corners.begin(), corners.end());

  // Cells take turns: each round every cell may give its strongest remaining corner, the emptiest cells first.
  const auto cell_of = [&](double x, double y) {
    const int column =
        std::clamp(static_cast<int>(x * options_.grid_columns / picture.cols), 0, options_.grid_columns - 1);
    const int row = std::clamp(static_cast<int>(y * options_.grid_rows / picture.rows), 0, options_.grid_rows - 1);
    return static_cast<std::size_t>(row * options_.grid_columns + column);
  };
  std::vector<std::vector<Corner>> cells(static_cast<std::size_t>(options_.grid_columns * options_.grid_rows));
  std::vector<int> filled(cells.size(), 0);
  std::vector<Eigen::Vector2d> occupied(taken.begin(), taken.end());
  for (const Eigen::Vector2d& pixel : taken) ++filled[cell_of(pixel.x(), pixel.y())];
  for (const Corner& corner : corners) cells[cell_of(corner.x, corner.y)].push_back(corner);
  std::vector<std::size_t> next(cells.size(), 0);
  const double spacing = options_.min_spacing * options_.min_spacing;
  const auto is_free = [&](const Corner& corner) {
    return std::none_of(occupied.begin(), occupied.end(), [&](const Eigen::Vector2d& pixel) {
      return (pixel - Eigen::Vector2d(corner.x, corner.y)).squaredNorm() < spacing;
    });
  };
  for (int level = 0; static_cast<int>(chosen.size()) < wanted; ++level) {
    bool any_left = false;
    for (std::size_t cell = 0; cell < cells.size() && static_cast<int>(chosen.size()) < wanted; ++cell) {
      if (next[cell] >= cells[cell].size()) continue;
      any_left = true;
      if (filled[cell] > level) continue;
      while (next[cell] < cells[cell].size()) {
        const Corner& corner = cells[cell][next[cell]++];
        if (!is_free(corner)) continue;
        chosen.emplace_back(corner.x, corner.y);
        occupied.emplace_back(corner.x, corner.y);
        ++filled[cell];
        break;
      }
    }
    if (!any_left) break;
  }
  return chosen;
}

std::unique_ptr<FrontEnd> make_front_end(const FrontEndOptions& options, std::size_t cameras) {
  switch (options.kind) {
    case FrontEndKind::kShiTomasiKlt:
      break;
  }
  return std::make_unique<KltFrontEnd>(options, cameras);
}

}  // namespace slamfuse::visual_slam
