// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/image_clock.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "common/angle.hpp"
#include "common/median.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Nanoseconds;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kGridStep = 0.02;         // [s]
constexpr double kFineStep = 0.002;        // [s]
constexpr double kOutOfStep = 0.01;        // [s] of one camera when another one's stamps are wrong
constexpr std::size_t kFewestTurns = 30;   // pictures to decide by
constexpr std::size_t kFitInterval = 10;   // pictures from one fit to the next
constexpr std::size_t kEnoughTurns = 100;  // after so many a clock that is right is not watched any more
constexpr double kBetter = 0.8;            // misfit over that of the stamps as they are
constexpr double kSignificance = 5.0;      // standard deviations
constexpr int kEnoughWidth = 400;          // [px] of pictures; turns are seen well enough in halves of wider ones
constexpr Nanoseconds kLongestStep = common::kNanosecondsPerSecond;  // from picture to picture

/// Where one feature is seen in two pictures: unit vectors in base_link's axes at the time of each.
struct RayPair {
  Eigen::Vector3d before;
  Eigen::Vector3d after;
};

Eigen::Vector3d ray_of(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d point = camera.calibration.undistort(pixel);
  return (camera.R_base_camera * point.homogeneous()).normalized();
}

/// Mean angle [rad], each cut off, by which rays miss the epipolar planes of a turn by `turn` and a way of `distance`
/// [m] along the arc; the camera sits at `lever` in base_link [m].
double epipolar_misfit(const std::vector<RayPair>& rays, const Eigen::Vector2d& lever, double turn, double distance) {
  constexpr double kCutOff = 0.01;      // [rad]
  constexpr double kNearEpipole = 0.1;  // rays closer to it [rad] say nothing
  const Eigen::Rotation2Dd rotation(turn);
  const Eigen::Vector2d way =
      distance * Eigen::Vector2d(std::cos(0.5 * turn), std::sin(0.5 * turn)) + rotation * lever - lever;
  const Eigen::Vector3d direction = Eigen::Vector3d(way.x(), way.y(), 0.0).normalized();
  const Eigen::AngleAxisd turned(turn, Eigen::Vector3d::UnitZ());
  double sum = 0.0;
  int count = 0;
  for (const RayPair& ray : rays) {
    const Eigen::Vector3d normal = direction.cross(ray.before);
    if (normal.norm() < kNearEpipole) continue;
    sum += std::min(std::abs(normal.normalized().dot(turned * ray.after)), kCutOff);
    ++count;
  }
  return count > 0 ? sum / count : kInfinity;
}

/// The turn that two pictures show. Of a robot that stands or turns on the spot all azimuths change by it. Else near
/// things move further than far ones, and it is that for which the rays lie best in their epipolar planes, the way
/// being along the arc as wheels roll; `distance` [m] need be known but roughly.
double turn_of(const std::vector<RayPair>& rays, const Eigen::Vector2d& lever, double distance) {
  constexpr double kStands = 0.01;   // [m]
  constexpr double kReach = 0.08;    // [rad]
  constexpr double kCoarse = 0.002;  // [rad]
  constexpr double kFine = 0.0002;   // [rad]
  std::vector<double> turns;
  turns.reserve(rays.size());
  for (const RayPair& ray : rays) {
    turns.push_back(
        common::angle_difference(std::atan2(ray.before.y(), ray.before.x()), std::atan2(ray.after.y(), ray.after.x())));
  }
  double best = common::median(std::move(turns));
  if (std::abs(distance) < kStands) return best;
  double smallest = kInfinity;
  for (const auto& [reach, step] : {std::pair{kReach, kCoarse}, std::pair{kCoarse, kFine}}) {
    const double about = best;
    const int steps = static_cast<int>(std::lround(reach / step));
    for (int n = -steps; n <= steps; ++n) {
      const double misfit = epipolar_misfit(rays, lever, about + n * step, distance);
      if (misfit >= smallest) continue;
      smallest = misfit;
      best = about + n * step;
    }
  }
  return best;
}

/// Mean of all but the largest tenth.
double truncated_mean(std::vector<double>& values) {
  const auto kept = static_cast<std::ptrdiff_t>(values.size() - values.size() / 10);
  std::nth_element(values.begin(), values.begin() + kept - 1, values.end());
  return std::accumulate(values.begin(), values.begin() + kept, 0.0) / static_cast<double>(kept);
}

}  // namespace

void ImageClock::add(const common::WheelOdometry& odometry) {
  if (!may_change()) return;
  const Nanoseconds memory = common::from_seconds(options_.memory + options_.most_offset);
  while (!places_.empty() && places_.back().stamp >= odometry.stamp) places_.pop_back();
  const double last = places_.empty() ? 0.0 : places_.back().theta;
  places_.push_back(
      {odometry.stamp, last + common::angle_difference(odometry.pose.theta, last), odometry.pose.translation()});
  while (places_.front().stamp < odometry.stamp - memory) places_.pop_front();
}

std::optional<ImageClock::Place> ImageClock::place_at(Nanoseconds stamp) const {
  const auto after = std::lower_bound(places_.begin(), places_.end(), stamp,
                                      [](const Place& place, Nanoseconds t) { return place.stamp < t; });
  if (after == places_.end() || after == places_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double fraction =
      static_cast<double>(stamp - before->stamp) / static_cast<double>(after->stamp - before->stamp);
  return Place{stamp, before->theta + fraction * (after->theta - before->theta),
               before->position + fraction * (after->position - before->position)};
}

std::optional<double> ImageClock::odometry_turn(const Turn& turn, double offset) const {
  const Nanoseconds shift = common::from_seconds(offset);
  const auto from = place_at(turn.from + shift);
  const auto to = place_at(turn.to + shift);
  if (!from || !to) return std::nullopt;
  return to->theta - from->theta;
}

std::vector<double> ImageClock::misfits(double offset) const {
  constexpr double kMostScaleError = 0.1;
  std::vector<std::pair<double, double>> pairs;  // by the pictures, by the odometry
  double product = 0.0;
  double square = 0.0;
  for (const Turn& turn : turns_) {
    const auto told = odometry_turn(turn, offset);
    if (!told) continue;
    pairs.emplace_back(turn.angle, *told);
    product += turn.angle * *told;
    square += *told * *told;
  }
  const double scale = square > 0.0 ? std::clamp(product / square, 1.0 - kMostScaleError, 1.0 + kMostScaleError) : 1.0;
  std::vector<double> misfits;
  misfits.reserve(pairs.size());
  for (const auto& [seen, told] : pairs) misfits.push_back(std::abs(seen - scale * told));
  return misfits;
}

double ImageClock::misfit(double offset) const {
  std::vector<double> values = misfits(offset);
  return values.size() < kFewestTurns ? kInfinity : truncated_mean(values);
}

ImageClock::Small ImageClock::shrunk(const cv::Mat& picture) {
  Small small{picture, 1.0};
  while (small.picture.cols > kEnoughWidth) {
    cv::Mat half;
    cv::pyrDown(small.picture, half);
    small = {half, 2.0 * small.scale};
  }
  if (small.scale == 1.0) small.picture = picture.clone();
  return small;
}

std::optional<double> ImageClock::turn_to(const cv::Mat& after, double distance) {
  constexpr int kFeatures = 80;
  constexpr std::size_t kSearched = 40;  // the strongest tell the turn well enough to start from
  constexpr std::size_t kFewest = 15;
  constexpr double kApart = 15.0;    // [px]
  constexpr double kQuality = 0.01;  // of the best corner
  const cv::Size window(21, 21);
  constexpr int kLevels = 3;
  constexpr float kLargestError = 20.0F;
  const Small before = std::exchange(last_, shrunk(after));
  std::vector<cv::Point2f> corners;
  if (!before.picture.empty()) {
    cv::goodFeaturesToTrack(before.picture, corners, kFeatures, kQuality, kApart / before.scale);
  }
  const auto pixel_at = [&before](const cv::Point2f& point) -> Eigen::Vector2d {
    return before.scale * Eigen::Vector2d(static_cast<double>(point.x), static_cast<double>(point.y));
  };
  std::vector<ExpectedFeature> unmoved;
  unmoved.reserve(corners.size());
  for (const cv::Point2f& corner : corners) unmoved.push_back({0, pixel_at(corner), pixel_at(corner)});
  const double about = search_.find(0, camera_, after, std::span(unmoved).first(std::min(unmoved.size(), kSearched)));
  if (corners.size() < kFewest) return std::nullopt;
  std::vector<cv::Point2f> found;
  for (const ExpectedFeature& feature : unmoved) {
    const Eigen::Vector2d pixel = turned_pixel(camera_, feature.last, about).value_or(feature.last) / before.scale;
    found.emplace_back(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
  }
  std::vector<unsigned char> is_found;
  std::vector<float> errors;
  const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01);
  cv::calcOpticalFlowPyrLK(before.picture, last_.picture, corners, found, is_found, errors, window, kLevels, until,
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  std::vector<RayPair> rays;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (is_found[i] == 0 || errors[i] > kLargestError) continue;
    rays.push_back({ray_of(camera_, pixel_at(corners[i])), ray_of(camera_, pixel_at(found[i]))});
  }
  if (rays.size() < kFewest) return std::nullopt;
  return turn_of(rays, camera_.t_base_camera.head<2>(), distance);
}

/// How far the wheels drove in a stretch of time that ends no later than they are known to.
double ImageClock::distance(Nanoseconds from, Nanoseconds to) const {
  if (places_.empty()) return 0.0;
  const Nanoseconds ahead = std::max<Nanoseconds>(to - places_.back().stamp, 0);
  const auto begin = place_at(from - ahead);
  const auto end = place_at(to - ahead);
  if (!begin || !end) return 0.0;
  const double heading = 0.5 * (begin->theta + end->theta);
  return (end->position - begin->position).dot(Eigen::Vector2d(std::cos(heading), std::sin(heading)));
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

  double information = 0.0;
  for (const Turn& turn : turns_) {
    const auto earlier = odometry_turn(turn, best.offset - kGridStep);
    const auto later = odometry_turn(turn, best.offset + kGridStep);
    if (!earlier || !later) continue;
    const double slope = (*later - *earlier) / (2.0 * kGridStep);
    information += slope * slope;
    ++best.turns;
  }
  if (best.turns < kFewestTurns || !(information > 0.0)) return std::nullopt;
  best.sigma = std::sqrt(std::numbers::pi / 2.0) * best.misfit / std::sqrt(information);
  best.current = misfit(common::to_seconds(correction()));
  return best;
}

std::optional<double> ImageClock::watch(const cv::Mat& picture, Nanoseconds stamp) {
  if (!may_change()) return std::nullopt;
  const std::optional<double> turn = turn_to(picture, distance(last_stamp_ + correction(), stamp + correction()));
  const Nanoseconds from = std::exchange(last_stamp_, stamp);
  if (stamp < from - kLongestStep) turns_.clear();  // the clock was set
  if (stamp <= from || stamp - from > kLongestStep) return std::nullopt;
  if (turn) turns_.push_back({from, stamp, *turn});
  while (!turns_.empty() && turns_.front().from < stamp - common::from_seconds(options_.memory)) turns_.pop_front();
  if (++since_fit_ < kFitInterval) return std::nullopt;
  since_fit_ = 0;
  const auto found = fit();
  if (!found || found->sigma > options_.most_sigma) return std::nullopt;
  const double change = found->offset - common::to_seconds(correction());
  if (std::abs(change) < smallest_offset_) {
    settled_ = found->turns >= kEnoughTurns;
    return std::nullopt;
  }
  const bool is_clear = std::abs(change) > kSignificance * found->sigma && found->misfit < kBetter * found->current;
  if (!is_clear) return std::nullopt;
  found_ = {common::from_seconds(found->offset), std::hypot(found->sigma, kFineStep)};
  return change;
}

void ImageClock::share(std::vector<ImageClock>& clocks) {
  constexpr double kAlike = 3.0;  // standard deviations
  std::vector<Correction> found;
  for (const ImageClock& clock : clocks) {
    if (clock.found_) found.push_back(*clock.found_);
  }
  for (ImageClock& clock : clocks) {
    if (!clock.found_) {
      clock.smallest_offset_ = std::min(clock.smallest_offset_, kOutOfStep);
      clock.settled_ = clock.settled_ && found.empty();
      continue;
    }
    double sum = 0.0;
    double weights = 0.0;
    for (const Correction& other : found) {
      const double difference = common::to_seconds(other.correction - clock.found_->correction);
      if (std::abs(difference) > kAlike * std::hypot(clock.found_->sigma, other.sigma)) continue;
      const double weight = 1.0 / (other.sigma * other.sigma);
      sum += weight * difference;
      weights += weight;
    }
    clock.found_->correction += common::from_seconds(sum / weights);
  }
}

}  // namespace slamfuse::visual_slam
