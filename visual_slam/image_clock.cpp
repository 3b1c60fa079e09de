// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/image_clock.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "common/angle.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Nanoseconds;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kGridStep = 0.02;         // [s]
constexpr double kFineStep = 0.002;        // [s]
constexpr std::size_t kFewestTurns = 30;   // pictures to decide by
constexpr std::size_t kFitInterval = 10;   // pictures from one fit to the next
constexpr std::size_t kEnoughTurns = 100;  // after so many a clock that is right is not watched any more
constexpr double kBetter = 0.8;            // misfit over that of the stamps as they are
constexpr double kSignificance = 5.0;      // standard deviations
constexpr Nanoseconds kLongestStep = common::kNanosecondsPerSecond;  // from picture to picture

/// Mean of all but the largest tenth.
double truncated_mean(std::vector<double>& values) {
  const auto kept = static_cast<std::ptrdiff_t>(values.size() - values.size() / 10);
  std::nth_element(values.begin(), values.begin() + kept - 1, values.end());
  return std::accumulate(values.begin(), values.begin() + kept, 0.0) / static_cast<double>(kept);
}

}  // namespace

void ImageClock::add(const common::WheelOdometry& odometry) {
  if (settled_ || !options_.correct) return;
  const Nanoseconds memory = common::from_seconds(options_.memory + options_.most_offset);
  while (!headings_.empty() && headings_.back().stamp >= odometry.stamp) headings_.pop_back();
  const double last = headings_.empty() ? 0.0 : headings_.back().theta;
  headings_.push_back({odometry.stamp, last + common::angle_difference(odometry.pose.theta, last)});
  while (headings_.front().stamp < odometry.stamp - memory) headings_.pop_front();
}

std::optional<double> ImageClock::heading_at(Nanoseconds stamp) const {
  const auto after = std::lower_bound(headings_.begin(), headings_.end(), stamp,
                                      [](const Heading& heading, Nanoseconds t) { return heading.stamp < t; });
  if (after == headings_.end() || after == headings_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double fraction =
      static_cast<double>(stamp - before->stamp) / static_cast<double>(after->stamp - before->stamp);
  return before->theta + fraction * (after->theta - before->theta);
}

std::optional<double> ImageClock::odometry_turn(const Turn& turn, double offset) const {
  const Nanoseconds shift = common::from_seconds(offset);
  const auto from = heading_at(turn.from + shift);
  const auto to = heading_at(turn.to + shift);
  if (!from || !to) return std::nullopt;
  return *to - *from;
}

double ImageClock::misfit(double offset) const {
  std::vector<double> misfits;
  for (const Turn& turn : turns_) {
    if (const auto expected = odometry_turn(turn, offset)) misfits.push_back(std::abs(turn.angle - *expected));
  }
  return misfits.size() < kFewestTurns ? kInfinity : truncated_mean(misfits);
}

std::optional<double> ImageClock::turn_between(const cv::Mat& before, const cv::Mat& after) const {
  constexpr int kFeatures = 80;
  constexpr std::size_t kFewest = 15;
  constexpr double kApart = 15.0;    // [px]
  constexpr double kQuality = 0.01;  // of the best corner
  const cv::Size window(21, 21);
  constexpr int kLevels = 4;  // reaches some 100 px
  constexpr float kLargestError = 20.0F;
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(before, corners, kFeatures, kQuality, kApart);
  if (corners.size() < kFewest) return std::nullopt;
  std::vector<cv::Point2f> found;
  std::vector<unsigned char> is_found;
  std::vector<float> errors;
  cv::calcOpticalFlowPyrLK(before, after, corners, found, is_found, errors, window, kLevels);
  const auto azimuth = [this](const cv::Point2f& pixel) {
    const Eigen::Vector3d ray =
        camera_.R_base_camera *
        camera_.calibration.undistort({static_cast<double>(pixel.x), static_cast<double>(pixel.y)}).homogeneous();
    return std::atan2(ray.y(), ray.x());
  };
  std::vector<double> turns;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (is_found[i] == 0 || errors[i] > kLargestError) continue;
    turns.push_back(common::angle_difference(azimuth(corners[i]), azimuth(found[i])));
  }
  if (turns.size() < kFewest) return std::nullopt;
  const auto middle = turns.begin() + static_cast<std::ptrdiff_t>(turns.size() / 2);
  std::nth_element(turns.begin(), middle, turns.end());
  return *middle;
}

std::optional<ImageClock::Fit> ImageClock::fit() const {
  Fit best;
  best.misfit = kInfinity;
  const auto look_at = [&](double offset) {
    const double value = misfit(offset);
    if (value < best.misfit) {
      best.misfit = value;
      best.offset = offset;
    }
  };
  const int steps = static_cast<int>(std::ceil(options_.most_offset / kGridStep));
  for (int n = -steps; n <= steps; ++n) look_at(n * kGridStep);
  if (best.misfit == kInfinity || std::abs(best.offset) > (steps - 1) * kGridStep) return std::nullopt;
  const double middle = best.offset;
  const int fine_steps = static_cast<int>(kGridStep / kFineStep);
  for (int n = -fine_steps; n <= fine_steps; ++n) look_at(middle + n * kFineStep);

  std::vector<double> misfits;
  double information = 0.0;
  for (const Turn& turn : turns_) {
    const auto at = odometry_turn(turn, best.offset);
    const auto earlier = odometry_turn(turn, best.offset - kGridStep);
    const auto later = odometry_turn(turn, best.offset + kGridStep);
    if (!at || !earlier || !later) continue;
    const double slope = (*later - *earlier) / (2.0 * kGridStep);
    information += slope * slope;
    misfits.push_back(std::abs(turn.angle - *at));
  }
  if (misfits.size() < kFewestTurns || !(information > 0.0)) return std::nullopt;
  best.turns = misfits.size();
  best.sigma = std::sqrt(std::numbers::pi / 2.0) * truncated_mean(misfits) / std::sqrt(information);
  best.current = misfit(common::to_seconds(correction_));
  return best;
}

std::optional<double> ImageClock::watch(const cv::Mat& picture, Nanoseconds stamp) {
  if (settled_ || !options_.correct) return std::nullopt;
  const cv::Mat before = last_picture_;
  const Nanoseconds from = last_stamp_;
  last_picture_ = picture.clone();
  last_stamp_ = stamp;
  if (before.empty() || stamp <= from || stamp - from > kLongestStep) return std::nullopt;
  if (const auto turn = turn_between(before, picture)) turns_.push_back({from, stamp, *turn});
  while (!turns_.empty() && turns_.front().from < stamp - common::from_seconds(options_.memory)) turns_.pop_front();
  if (++since_fit_ < kFitInterval) return std::nullopt;
  since_fit_ = 0;
  const auto found = fit();
  if (!found || found->sigma > options_.most_sigma) return std::nullopt;
  const double change = found->offset - common::to_seconds(correction_);
  if (std::abs(change) < options_.smallest_offset) {
    settled_ = found->turns >= kEnoughTurns;
    return std::nullopt;
  }
  const bool is_clear = std::abs(change) > kSignificance * found->sigma && found->misfit < kBetter * found->current;
  if (!is_clear) return std::nullopt;
  correction_ = common::from_seconds(found->offset);
  return change;
}

}  // namespace slamfuse::visual_slam
