// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/landmark_recogniser.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

namespace slamfuse::visual_slam {
namespace {

constexpr int kPatchRadius = 18;  // [px] of the picture kept of a landmark
constexpr int kPatchSide = 2 * kPatchRadius + 1;
constexpr int kTemplateRadius = 7;      // [px] of what is compared
constexpr std::size_t kMaxLooks = 6;    // views kept of a landmark
constexpr double kSimilarScale = 1.25;  // views nearer than this in distance...
constexpr double kSimilarAngle = 0.25;  // ...and direction [rad] are the same view
constexpr double kMaxAngle = 0.6;       // [rad] between views that can be compared
constexpr double kMinContrast = 4.0;    // standard deviation of gray values a template needs
constexpr double kClearlyBest = 0.06;   // the second best place must correlate this much less
constexpr int kPeakRadius = 3;          // [px] around the best place that belongs to its peak

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.dot(b) / (a.norm() * b.norm()), -1.0, 1.0));
}

/// Position of a parabola's top through three values at -1, 0, 1.
double parabola_top(float before, float at, float after) {
  const double curvature = before - 2.0 * at + after;
  return curvature >= 0.0 ? 0.0 : std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5);
}

/// The middle of a patch magnified by `scale`, as large as a template.
cv::Mat scaled_template(const cv::Mat& patch, double scale) {
  cv::Mat smooth = patch;
  if (scale < 0.8) cv::GaussianBlur(patch, smooth, {}, 0.5 / scale);
  const double centre = kTemplateRadius - scale * kPatchRadius;
  const cv::Mat warp = (cv::Mat_<double>(2, 3) << scale, 0.0, centre, 0.0, scale, centre);
  cv::Mat result;
  cv::warpAffine(smooth, result, warp, {2 * kTemplateRadius + 1, 2 * kTemplateRadius + 1}, cv::INTER_LINEAR,
                 cv::BORDER_REPLICATE);
  return result;
}

bool has_contrast(const cv::Mat& image) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(image, mean, deviation);
  return deviation[0] >= kMinContrast;
}

}  // namespace

bool LandmarkRecogniser::remember(std::int64_t landmark, const cv::Mat& picture, const Eigen::Vector2d& pixel,
                                  const Eigen::Vector3d& view) {
  if (pixel.x() < kPatchRadius || pixel.y() < kPatchRadius || pixel.x() > picture.cols - 1 - kPatchRadius ||
      pixel.y() > picture.rows - 1 - kPatchRadius) {
    return false;
  }
  std::vector<Look>& looks = looks_[landmark];
  for (const Look& look : looks) {
    const double scale = look.view.norm() / view.norm();
    if (std::max(scale, 1.0 / scale) < kSimilarScale && angle_between(look.view, view) < kSimilarAngle) return false;
  }
  if (looks.size() >= kMaxLooks) return false;
  cv::Mat patch;
  cv::getRectSubPix(picture, {kPatchSide, kPatchSide}, {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())},
                    patch);
  looks.push_back({patch, view});
  return true;
}

std::vector<common::LandmarkView> LandmarkRecogniser::views(std::int64_t landmark) const {
  std::vector<common::LandmarkView> views;
  const auto known = looks_.find(landmark);
  if (known == looks_.end()) return views;
  for (const Look& look : known->second) {
    views.push_back({look.view, look.descriptor, {look.patch.begin<std::uint8_t>(), look.patch.end<std::uint8_t>()}});
  }
  return views;
}

void LandmarkRecogniser::restore(std::int64_t landmark, std::span<const common::LandmarkView> views) {
  for (const common::LandmarkView& view : views) {
    if (view.patch.size() != static_cast<std::size_t>(kPatchSide * kPatchSide)) continue;
    looks_[landmark].push_back({cv::Mat(view.patch, true).reshape(1, kPatchSide), view.direction, view.descriptor});
  }
}

const LandmarkRecogniser::Look* LandmarkRecogniser::best_look(std::int64_t landmark,
                                                              const Eigen::Vector3d& view) const {
  const auto known = looks_.find(landmark);
  if (known == looks_.end()) return nullptr;
  const Look* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const Look& look : known->second) {
    const double scale = std::abs(std::log(look.view.norm() / view.norm()));
    const double angle = angle_between(look.view, view);
    if (scale > std::log(options_.max_scale_change) || angle > kMaxAngle) continue;
    const double difference = scale + angle;
    if (difference < least) {
      least = difference;
      best = &look;
    }
  }
  return best;
}

bool LandmarkRecogniser::comparable(std::int64_t landmark, const Eigen::Vector3d& view) const {
  return best_look(landmark, view) != nullptr;
}

std::optional<FoundFeature> LandmarkRecogniser::find(const cv::Mat& picture,
                                                     const RecognitionCandidate& candidate) const {
  const Look* look = best_look(candidate.id, candidate.view);
  if (look == nullptr) return std::nullopt;
  const cv::Mat pattern = scaled_template(look->patch, look->view.norm() / candidate.view.norm());
  if (!has_contrast(pattern)) return std::nullopt;
  const int radius = kTemplateRadius + std::max(2, static_cast<int>(std::ceil(candidate.radius)));
  const cv::Point middle(static_cast<int>(std::lround(candidate.predicted.x())),
                         static_cast<int>(std::lround(candidate.predicted.y())));
  const cv::Rect region = cv::Rect(middle.x - radius, middle.y - radius, 2 * radius + 1, 2 * radius + 1) &
                          cv::Rect(0, 0, picture.cols, picture.rows);
  if (region.width < pattern.cols + 2 || region.height < pattern.rows + 2) return std::nullopt;
  cv::Mat scores;
  cv::matchTemplate(picture(region), pattern, scores, cv::TM_CCOEFF_NORMED);
  double best = 0.0;
  cv::Point place;
  cv::minMaxLoc(scores, nullptr, &best, nullptr, &place);
  if (!(best >= options_.min_correlation) || place.x == 0 || place.y == 0 || place.x == scores.cols - 1 ||
      place.y == scores.rows - 1) {
    return std::nullopt;
  }
  const double dx = parabola_top(scores.at<float>(place.y, place.x - 1), static_cast<float>(best),
                                 scores.at<float>(place.y, place.x + 1));
  const double dy = parabola_top(scores.at<float>(place.y - 1, place.x), static_cast<float>(best),
                                 scores.at<float>(place.y + 1, place.x));
  cv::rectangle(scores, place - cv::Point(kPeakRadius, kPeakRadius), place + cv::Point(kPeakRadius, kPeakRadius),
                cv::Scalar(-1.0), cv::FILLED);
  double second = 0.0;
  cv::minMaxLoc(scores, nullptr, &second);
  if (second > best - kClearlyBest) return std::nullopt;
  return FoundFeature{candidate.id,
                      {region.x + place.x + kTemplateRadius + dx, region.y + place.y + kTemplateRadius + dy}};
}

std::optional<double> LandmarkRecogniser::likeness(std::int64_t landmark, const cv::Mat& picture,
                                                   const Eigen::Vector2d& pixel, const Eigen::Vector3d& view) const {
  const Look* look = best_look(landmark, view);
  if (look == nullptr) return std::nullopt;
  const cv::Mat pattern = scaled_template(look->patch, look->view.norm() / view.norm());
  cv::Mat here;
  cv::getRectSubPix(picture, pattern.size(), {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())}, here);
  cv::Mat score;
  cv::matchTemplate(here, pattern, score, cv::TM_CCOEFF_NORMED);
  return score.at<float>(0, 0);
}

}  // namespace slamfuse::visual_slam
