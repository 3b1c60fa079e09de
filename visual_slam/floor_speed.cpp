// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/floor_speed.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "common/pose2.hpp"

namespace slamfuse::visual_slam {
namespace {

// Between the pictures: in less the robot drives too little, after more the floor looks different [s].
constexpr double kShortest = 0.1;
constexpr double kLongest = 0.6;

constexpr double kBlur = 0.8;  // [px] sigma, against noise between the pixels
constexpr int kRadius = 9;     // of a patch [px]
constexpr int kSide = 2 * kRadius + 1;
constexpr int kColumnStep = 18;  // between patches [px]
constexpr int kRowStep = 14;
constexpr double kLeastFall = 0.12;  // of a ray for each metre along the optical axis: farther floor tells little
constexpr double kLeastTexture = 2.5 * kSide;  // of a patch, see cut()
constexpr double kLeastTextureBefore = 0.5 * kLeastTexture;

constexpr double kStep = 0.004;  // between ways that are tried [m]
constexpr int kMostSteps = 120;
constexpr double kBackward = 0.2;  // of the largest speed
constexpr float kLeastCorrelation = 0.85F;
constexpr double kBeside = 0.02;     // so far beside a patch's way [m] its correlation must be less ...
constexpr float kFall = 0.04F;       // ... by this much
constexpr double kPixelSigma = 0.4;  // of where a patch is found [px] ...
constexpr double kWaySigma = 0.002;  // ... and of the floor, which is not quite flat, and the tilt of the camera [m]

constexpr double kThickness = 0.25;  // so far below its known points a thing hides the floor for sure [m] ...
constexpr double kHalfWidth = 0.1;   // ... and so far to both sides [rad]

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
  template <class TurnOfWay>
  Ways(const WayRange& possible, const TurnOfWay& turn) : range(possible) {
    const double width = range.most - range.least;
    const int steps = std::clamp(static_cast<int>(width / kStep), 8, kMostSteps);
    step = width / steps;
    for (int i = 0; i <= steps; ++i) T_before_now.push_back(common::exp_se2({way(i), 0.0, turn(way(i))}));
  }
  double way(double i) const { return range.least + i * step; }
  std::size_t size() const { return T_before_now.size(); }

  WayRange range;
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

/// What the pixel shows if it shows the floor, in base_link; empty where that is too far away.
std::optional<Eigen::Vector3d> floor_at(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray = camera.R_base_camera * camera.calibration.undistort(pixel).homogeneous();
  if (ray.z() > -kLeastFall) return std::nullopt;
  return camera.t_base_camera - ray * (camera.t_base_camera.z() / ray.z());
}

/// Whether the line of sight to the floor goes through the thing a point is on: below the point, but not by far, which
/// may be under a table.
bool hides(const Camera& camera, const Eigen::Vector3d& floor, const Eigen::Vector3d& standing) {
  const Eigen::Vector2d to_floor = (floor - camera.t_base_camera).head<2>();
  const Eigen::Vector2d to_point = (standing - camera.t_base_camera).head<2>();
  const double share = to_point.norm() / to_floor.norm();
  if (share > 1.0 || to_point.dot(to_floor) < std::cos(kHalfWidth) * to_point.norm() * to_floor.norm()) return false;
  const double height = camera.t_base_camera.z() * (1.0 - share);
  return height < standing.z() && height > standing.z() - kThickness;
}

/// At which way a patch of the picture `now` is found in the one before, if at one only.
std::optional<WayVote> vote(const Camera& camera, const cv::Mat& now, const cv::Mat& before,
                            const Eigen::Vector2d& pixel, const Eigen::Vector3d& floor, const Ways& ways) {
  cv::Mat patch;
  const double texture = cut(now, pixel, patch);
  if (texture < kLeastTexture) return std::nullopt;
  patch = (patch - cv::mean(patch)[0]) / texture;
  const Eigen::Vector3d& centre = camera.t_base_camera;
  std::vector<float> found(ways.size(), -1.0F);
  cv::Mat other;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const Eigen::Vector2d place = ways.T_before_now[i] * Eigen::Vector2d(floor.head<2>());
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
  const double for_a_pixel = (floor - centre).squaredNorm() / (camera.focal_length * centre.z());  // [m] of the floor
  return WayVote{ways.way(top_near(found, best)), std::hypot(kPixelSigma * for_a_pixel, kWaySigma)};
}

}  // namespace

bool FloorSpeed::may_see_floor(const Camera& camera) {
  const Eigen::Vector2d lowest(0.5 * camera.calibration.width, camera.calibration.height - 1.0);
  return camera.t_base_camera.z() > 0.0 && floor_at(camera, lowest).has_value();
}

WayRange FloorSpeed::possible_ways(double seconds) const {
  return {-kBackward * options_.max_speed * seconds, options_.max_speed * seconds};
}

double FloorSpeed::Reference::turn(double way_driven) const {
  double sum = 0.0;
  for (const Step& step : steps) sum += step.turn(way_driven * step.seconds / seconds);
  return sum;
}

void FloorSpeed::moved(double seconds, double speed, const TurnByWay& turn) {
  if (seconds <= 0.0) return;
  speed_ = speed;
  for (Reference& reference : references_) {
    if (reference.picture.empty()) continue;
    reference.steps.push_back({seconds, turn});
    reference.seconds += seconds;
    if (reference.seconds > kLongest) {
      reference = {};  // too old to be compared with, and its steps would pile up in the dark
      continue;
    }
    reference.way += seconds * speed;
  }
}

std::optional<FloorSpeed::Reading> FloorSpeed::read(std::size_t index, const Camera& camera, const cv::Mat& picture,
                                                    common::Nanoseconds stamp,
                                                    std::span<const Eigen::Vector3d> standing) {
  if (!options_.enabled || camera.t_base_camera.z() <= 0.0) return std::nullopt;
  Reference& reference = references_[index];
  const double seconds = common::to_seconds(stamp - reference.stamp);
  if (!reference.picture.empty() && seconds >= 0.0 && seconds < kShortest) return std::nullopt;
  Reference now;
  now.stamp = stamp;
  cv::GaussianBlur(picture, now.picture, {0, 0}, kBlur);
  const Reference before = std::exchange(reference, now);
  if (before.picture.empty() || seconds < 0.0 || seconds > kLongest) return std::nullopt;
  const auto driven = way(camera, now.picture, before, seconds, standing);
  if (!driven) return std::nullopt;
  const double change = speed_ - before.way / seconds;
  return Reading{*driven / seconds + change, seconds};
}

std::optional<double> FloorSpeed::way(const Camera& camera, const cv::Mat& now, const Reference& before, double seconds,
                                      std::span<const Eigen::Vector3d> standing) const {
  const Ways ways(possible_ways(seconds), [&before](double driven) { return before.turn(driven); });
  std::vector<WayVote> votes;
  for (int row = kRowStep; row < now.rows; row += kRowStep) {
    for (int column = kColumnStep / 2; column < now.cols; column += kColumnStep) {
      const Eigen::Vector2d pixel(column, row);
      const std::optional<Eigen::Vector3d> floor = floor_at(camera, pixel);
      if (!floor) continue;
      const auto stands_before = [&](const Eigen::Vector3d& point) { return hides(camera, *floor, point); };
      if (std::any_of(standing.begin(), standing.end(), stands_before)) continue;
      if (const auto said = vote(camera, now, before.picture, pixel, *floor, ways)) votes.push_back(*said);
    }
  }
  if (static_cast<int>(votes.size()) < options_.least_patches) return std::nullopt;
  return likeliest_way(votes, ways.range);
}

}  // namespace slamfuse::visual_slam
