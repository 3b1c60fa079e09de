// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/floor_reckoning.hpp"

#include <cmath>

namespace slamfuse::visual_slam {
namespace {

constexpr double kSharpTurn = 0.08;      // [rad] tells one way from another by the features followed ...
constexpr double kLeastLikelihood = -3;  // ... which must not contradict the floor's (logarithm)
// What is higher than this share of the camera's height stands on the floor, also in a map that is a quarter too small.
constexpr double kStandingHeight = 0.25;

// How wrong the speed of a filter may be that the floor contradicts [m/s].
constexpr double kDoubt = 0.3;
constexpr int kFewestRefusals = 6;  // within floor_speed.patience, that contradict a map ...
constexpr int kFewestOfAGuess = 2;  // ... or one that has only begun

/// Where those landmarks are, in base_link, that are known to be above the floor.
std::vector<Eigen::Vector3d> standing_points(const Ekf& filter, const FloorView& view) {
  const common::Pose2 pose = filter.pose();
  std::vector<Eigen::Vector3d> points;
  for (const LandmarkId id : view.landmarks) {
    const std::optional<Eigen::Vector3d> at = filter.likely_position(id);
    if (!at || at->z() <= kStandingHeight * view.camera.t_base_camera.z()) continue;
    const Eigen::Vector2d place = pose.inverse() * Eigen::Vector2d(at->head<2>());
    points.emplace_back(place.x(), place.y(), at->z());
  }
  return points;
}

double metric_speed(const Ekf& filter) { return filter.twist()->linear.x() / filter.lever_scale(); }

}  // namespace

bool FloorReckoning::tells_metres(common::Nanoseconds stamp) const {
  return believed_ && stamp - *believed_ < common::from_seconds(options_.memory);
}

void FloorReckoning::age(Ekf& filter, std::span<const LandmarkId> landmarks, double seconds) const {
  filter.let_scale_drift(landmarks, options_.scale_drift * std::sqrt(seconds));
}

TurnByWay FloorReckoning::turn(const Ekf& filter, const FloorView& view) const {
  const double believed = view.seconds * filter.twist()->angular.z();
  // What was followed over images that showed nothing new says nothing of the last step.
  if (view.landmarks_spoke || skipped_) return TurnByWay(believed);
  const WayRange ways = speed_.possible_ways(view.seconds);
  return {view.camera, view.followed, {view.seconds, turn_rate_}, ways.least, ways.most, believed};
}

FloorReckoning::Verdict FloorReckoning::read(Ekf& filter, const FloorView& view) {
  const TurnByWay turned = turn(filter, view);
  const double speed = metric_speed(filter);
  turn_rate_ = view.seconds > 0.0 ? turned(speed * view.seconds) / view.seconds : 0.0;
  speed_.moved(view.seconds, speed, turned);
  skipped_ = false;
  if (view.picture.empty()) return Verdict::kSilent;
  if (!begun_) begun_ = view.stamp;
  // A map that is too small lifts the floor itself, so it must be in metres.
  const auto standing = tells_metres(view.stamp) ? standing_points(filter, view) : std::vector<Eigen::Vector3d>();
  const auto reading = speed_.read(view.camera_index, view.camera, view.picture, view.stamp, standing);
  if (!reading) return Verdict::kSilent;
  const double way = reading->speed * view.seconds;
  const double turned_since = turned(way) * reading->seconds / view.seconds;  // the picture compared with, about
  if (std::abs(turned_since) > kSharpTurn && turned.log_likelihood(way) < kLeastLikelihood) return Verdict::kSilent;
  return judge(filter, *reading, view.stamp);
}

FloorReckoning::Verdict FloorReckoning::judge(Ekf& filter, const FloorSpeed::Reading& reading,
                                              common::Nanoseconds stamp) {
  const double sigma = options_.way_sigma / reading.seconds;
  if (filter.correct_speed(reading.speed, sigma)) {
    believed_ = stamp;
    refusing_since_.reset();
    return Verdict::kBelieved;
  }
  const common::Nanoseconds patience = common::from_seconds(options_.patience);
  if (!refusing_since_ || stamp - *refused_ > patience) {
    refusing_since_ = stamp;
    refusals_ = 0;
  }
  refused_ = stamp;
  ++refusals_;
  const bool guessed = !believed_ && stamp - *begun_ < patience && refusals_ >= kFewestOfAGuess;
  const bool steady = stamp - *refusing_since_ >= patience && refusals_ >= kFewestRefusals;
  if (!guessed && !steady) return Verdict::kRefused;
  refusing_since_.reset();
  filter.doubt_speed(kDoubt);
  if (!filter.correct_speed(reading.speed, sigma)) return Verdict::kRefused;
  believed_ = stamp;
  return guessed ? Verdict::kWrongGuess : Verdict::kContradicted;
}

void FloorReckoning::skip(const Ekf& filter, double seconds) {
  const double rate = filter.twist()->angular.z();
  turn_rate_ = rate;
  skipped_ = true;
  speed_.moved(seconds, metric_speed(filter), TurnByWay(rate * seconds));
}

}  // namespace slamfuse::visual_slam
