// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/floor_speed.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "common/pose2.hpp"

namespace slamfuse::visual_slam {
namespace {

// Between the pictures: in less the robot drives too little, after more the floor looks different [s].
constexpr double kShortest = 0.1;
constexpr double kLongest = 0.6;

// A speed that does not follow from the one told before is that of something else, as a bed's in place of the floor's.
// It may be told for seconds, so waiting makes it no more plausible for long [s] ...
constexpr double kPatience = 0.4;
// ... but when nothing that follows was seen for so long [s], what was told before says nothing any more.
constexpr double kForgetful = 3.0;

constexpr double kBlur = 0.8;  // [px] sigma, against noise between the pixels
constexpr int kRadius = 6;     // of a patch [px]
constexpr int kSide = 2 * kRadius + 1;
constexpr int kColumnStep = 18;  // between patches [px]
constexpr int kRowStep = 14;
constexpr double kLeastFall = 0.12;     // of a ray for each metre along the optical axis: farther floor tells little
constexpr double kLeastTexture = 60.0;  // of a patch, see cut()
constexpr double kLeastTextureBefore = 30.0;

constexpr double kStep = 0.004;  // between ways that are tried [m]
constexpr int kMostSteps = 120;
constexpr double kBackward = 0.2;  // of the largest speed
constexpr float kLeastCorrelation = 0.85F;
constexpr double kBeside = 0.02;  // so far beside a patch's way [m] its correlation must be less ...
constexpr float kFall = 0.08F;    // ... by this much
constexpr float kMostWeight = 0.3F;
constexpr double kVoteSigma = 0.006;  // of a vote [m]
constexpr double kRivalFrom = 0.02;   // farther away [m] it is another way

/// Cuts the patch around a point of the picture and gives its texture: the length of it without its mean, 0 outside.
double cut(const cv::Mat& picture, const Eigen::Vector2d& centre, cv::Mat& patch) {
  const double border = kRadius + 1;
  const bool inside = centre.x() >= border && centre.y() >= border && centre.x() < picture.cols - border - 1 &&
                      centre.y() < picture.rows - border - 1;
  if (!inside) return 0.0;
  cv::getRectSubPix(picture, {kSide, kSide}, {static_cast<float>(centre.x()), static_cast<float>(centre.y())}, patch,
                    CV_32F);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(patch, mean, deviation);
  return deviation[0] * kSide;
}

/// The ways that are tried, and where base_link was if it has driven them.
struct Ways {
  Ways(double largest_speed, double seconds, double turn) {
    const double most = largest_speed * seconds;
    least = -kBackward * most;
    const int steps = std::clamp(static_cast<int>((most - least) / kStep), 8, kMostSteps);
    step = (most - least) / steps;
    for (int i = 0; i <= steps; ++i) T_before_now.push_back(common::exp_se2({way(i), 0.0, turn}));
  }
  double way(double i) const { return least + i * step; }
  std::size_t size() const { return T_before_now.size(); }

  double least = 0.0;
  double step = 0.0;
  std::vector<common::Pose2> T_before_now;
};

/// Where between i - 1 and i + 1 a parabola through the three values has its top.
template <class Values>
double top_near(const Values& values, std::size_t i) {
  const double before = values[i - 1];
  const double here = values[i];
  const double after = values[i + 1];
  const double bend = before - 2.0 * here + after;
  const double shift = bend < 0.0 ? 0.5 * (before - after) / bend : 0.0;
  return static_cast<double>(i) + shift;
}

/// What one patch says.
struct Vote {
  double way = 0.0;
  double weight = 0.0;
};

/// At which way a patch of the picture `now` is found in the one before, if at one only.
std::optional<Vote> vote(const Camera& camera, const cv::Mat& now, const cv::Mat& before, const Eigen::Vector2d& pixel,
                         const Ways& ways) {
  const Eigen::Vector3d ray = camera.R_base_camera * camera.calibration.undistort(pixel).homogeneous();
  if (ray.z() > -kLeastFall) return std::nullopt;
  cv::Mat patch;
  const double texture = cut(now, pixel, patch);
  if (texture < kLeastTexture) return std::nullopt;
  patch = (patch - cv::mean(patch)[0]) / texture;
  const Eigen::Vector3d& centre = camera.t_base_camera;
  const Eigen::Vector3d on_floor = centre - ray * (centre.z() / ray.z());
  std::vector<float> found(ways.size(), -1.0F);
  cv::Mat other;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const Eigen::Vector2d place = ways.T_before_now[i] * Eigen::Vector2d(on_floor.head<2>());
    const Eigen::Vector3d seen =
        camera.R_base_camera.transpose() * (Eigen::Vector3d(place.x(), place.y(), 0.0) - centre);
    const std::optional<Eigen::Vector2d> there = camera.calibration.project(seen);
    const double texture_there = there ? cut(before, *there, other) : 0.0;
    // The patch has no mean, so that of the other does not count.
    if (texture_there >= kLeastTextureBefore) found[i] = static_cast<float>(patch.dot(other) / texture_there);
  }
  const auto best = static_cast<std::size_t>(std::max_element(found.begin(), found.end()) - found.begin());
  if (best < 1 || best + 1 >= ways.size() || found[best] < kLeastCorrelation) return std::nullopt;
  const auto beside = static_cast<std::size_t>(std::max(2.0, std::round(kBeside / ways.step)));
  float side = -1.0F;
  if (best >= beside) side = std::max(side, found[best - beside]);
  if (best + beside < ways.size()) side = std::max(side, found[best + beside]);
  const float fall = found[best] - side;
  if (fall < kFall) return std::nullopt;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const bool elsewhere = i + beside < best || i > best + beside;
    if (elsewhere && found[i] > found[best] - kFall) return std::nullopt;  // what repeats could be at either
  }
  return Vote{ways.way(top_near(found, best)), std::min(fall, kMostWeight)};
}

}  // namespace

void FloorSpeed::moved(double seconds, double speed, double turn_rate) {
  speed_ = speed;
  for (Reference& reference : references_) {
    reference.turn += seconds * turn_rate;
    reference.way += seconds * speed;
  }
}

std::optional<FloorSpeed::Reading> FloorSpeed::read(std::size_t index, const Camera& camera, const cv::Mat& picture,
                                                    common::Nanoseconds stamp) {
  if (!options_.enabled || camera.t_base_camera.z() <= 0.0) return std::nullopt;
  Reference& reference = references_[index];
  const double seconds = common::to_seconds(stamp - reference.stamp);
  if (!reference.picture.empty() && seconds >= 0.0 && seconds < kShortest) return std::nullopt;
  Reference now{{}, stamp, 0.0, 0.0};
  cv::GaussianBlur(picture, now.picture, {0, 0}, kBlur);
  const Reference before = std::exchange(reference, now);
  if (before.picture.empty() || seconds < 0.0 || seconds > kLongest) return std::nullopt;
  const auto driven = way(camera, now.picture, before, seconds);
  if (!driven) return std::nullopt;
  const double change = speed_ - before.way / seconds;
  const double speed = *driven / seconds + change;
  if (!follows(speed, seconds, stamp)) return std::nullopt;
  told_ = Told{speed, stamp};
  return Reading{speed, seconds};
}

bool FloorSpeed::follows(double speed, double seconds, common::Nanoseconds stamp) const {
  if (!told_) return true;
  const double since = common::to_seconds(stamp - told_->stamp);
  if (since < 0.0 || since > kForgetful) return true;
  const double noise = 3.0 * std::numbers::sqrt2 * options_.way_sigma / seconds;
  return std::abs(speed - told_->speed) < noise + options_.max_acceleration * std::min(since, kPatience);
}

std::optional<double> FloorSpeed::way(const Camera& camera, const cv::Mat& now, const Reference& before,
                                      double seconds) const {
  const Ways ways(options_.max_speed, seconds, before.turn);
  std::vector<double> votes(ways.size(), 0.0);
  int voters = 0;
  for (int row = kRowStep; row < now.rows; row += kRowStep) {
    for (int column = kColumnStep / 2; column < now.cols; column += kColumnStep) {
      const auto said = vote(camera, now, before.picture, {column, row}, ways);
      if (!said) continue;
      ++voters;
      for (std::size_t i = 0; i < votes.size(); ++i) {
        const double off = (ways.way(static_cast<double>(i)) - said->way) / kVoteSigma;
        votes[i] += said->weight * std::exp(-0.5 * off * off);
      }
    }
  }
  if (voters < options_.least_patches) return std::nullopt;
  const auto best = static_cast<std::size_t>(std::max_element(votes.begin(), votes.end()) - votes.begin());
  if (best < 1 || best + 1 >= votes.size()) return std::nullopt;
  double rival = 0.0;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    const double away = std::abs(static_cast<double>(i) - static_cast<double>(best)) * ways.step;
    if (away > kRivalFrom) rival = std::max(rival, votes[i]);
  }
  if (rival > options_.max_rival * votes[best]) return std::nullopt;
  return ways.way(top_near(votes, best));
}

}  // namespace slamfuse::visual_slam
