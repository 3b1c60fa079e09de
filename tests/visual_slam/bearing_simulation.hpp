// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "common/angle.hpp"
#include "common/time.hpp"
#include "visual_slam/ekf.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam::testing {

/// A circle of 1.3 m radius in room_points' room, started at the origin; one pose an image.
inline std::vector<common::Pose2> circle_path(int images) {
  std::vector<common::Pose2> path(1);
  for (int i = 0; i < images; ++i) path.push_back(path.back() * common::exp_se2({0.08, 0.0, 0.06}));
  return path;
}

/// Drives the filter by hand, without images: a robot goes along a given path, its cameras see numbered points with
/// noise, its wheels are wrong by exactly what the options promise (systematic errors and noise, drawn by the seed).
/// What the filter believes of its own error can so be compared with the error over many runs.
class BearingSimulation {
 public:
  static constexpr double kPixelSigma = 1.0;
  static constexpr common::Nanoseconds kFrame = 200'000'000;
  static constexpr std::size_t kFeatures = 25;  // followed in an image

  BearingSimulation(unsigned seed, int cameras, std::vector<common::Pose2> path, std::vector<Eigen::Vector3d> points,
                    double reach = 100.0)
      : noise_(seed), path_(std::move(path)), points_(std::move(points)), reach_(reach) {
    if (points_.empty()) points_ = room_points(300, noise_);
    if (cameras > 0) cameras_.push_back(make_camera("cam0", 0.6));
    if (cameras > 1) cameras_.push_back(make_camera("cam1", -0.6, 0.1, -0.05));
    calibration_ = {motion_.distance_scale_sigma * noise_.gaussian(), motion_.turn_scale_sigma * noise_.gaussian(),
                    common::to_radians(motion_.turn_per_distance_sigma) * noise_.gaussian()};
  }

  bool done() const { return next_ >= path_.size(); }

  /// Drives on by one pose of the path and looks. The map begins at the path's first pose.
  void step(Ekf& filter) {
    filter.predict({common::to_seconds(kFrame), measured_increment(path_[next_ - 1].inverse() * path_[next_])});
    ++next_;
    for (const Camera& camera : cameras_) look(filter, camera);
    stamp_ += kFrame;
  }

  /// Where the robot is, in the map.
  common::Pose2 truth() const { return path_.front().inverse() * path_[next_ - 1]; }
  /// True minus estimated pose.
  Eigen::Vector3d error_of(const Ekf& filter) const {
    const common::Pose2 estimate = filter.pose(), here = truth();
    return {here.x - estimate.x, here.y - estimate.y, common::angle_difference(here.theta, estimate.theta)};
  }
  /// Normalised estimation error squared of the pose: 3 on average when the covariance is right.
  double nees(const Ekf& filter) const {
    const Eigen::Vector3d error = error_of(filter);
    return error.dot(filter.pose_covariance().inverse() * error);
  }

  int outliers_every = 0;  ///< each so many measurements one is wrong; 0 = none
  int outliers_made = 0;
  int outliers_accepted = 0;
  double assumed_pixel_sigma = kPixelSigma;  ///< what the filter is told of the noise
  std::size_t max_landmarks = 1000;          ///< above this, those longest unseen go

  /// The systematic errors of these wheels.
  const OdometryCalibration& calibration() const { return calibration_; }

 private:
  /// calibrate_increment backwards: what wheels with this robot's errors say of a true increment.
  common::Pose2 measured_increment(const common::Pose2& truth) {
    const Eigen::Vector3d way = common::log_se2(truth);
    const double distance = way.head<2>().norm();
    const double turns = std::abs(way.z()) / (2.0 * std::numbers::pi);
    const double turn_variance = std::pow(common::to_radians(motion_.turn_noise_per_distance), 2) * distance +
                                 std::pow(common::to_radians(motion_.turn_noise_per_turn), 2) * turns;
    Eigen::Vector3d raw;
    raw.x() = (way.x() + motion_.distance_noise * std::sqrt(distance) * noise_.gaussian()) / (1.0 + calibration_[0]);
    raw.y() = way.y() + motion_.lateral_noise * std::sqrt(distance) * noise_.gaussian();
    raw.z() =
        (way.z() + std::sqrt(turn_variance) * noise_.gaussian() - calibration_[2] * raw.x()) / (1.0 + calibration_[1]);
    return common::exp_se2(raw);
  }

  void look(Ekf& filter, const Camera& camera) {
    std::vector<Measurement> known;
    std::vector<Measurement> fresh;
    std::vector<bool> wrong;
    const common::Pose2 here = truth();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if ((points_[i].head<2>() - here.translation()).norm() > reach_) continue;
      const auto projection = project_cartesian(camera, {}, here, points_[i]);
      if (!projection) continue;
      const auto pixel = camera.calibration.project(projection->point.homogeneous());
      if (!pixel || !camera.sees(*pixel, 5.0)) continue;
      Eigen::Vector2d measured = *pixel + kPixelSigma * Eigen::Vector2d(noise_.gaussian(), noise_.gaussian());
      const auto id = static_cast<LandmarkId>(i);
      if (filter.has(id)) {
        wrong.push_back(outliers_every > 0 && ++count_ % outliers_every == 0);
        if (wrong.back()) measured += Eigen::Vector2d(40.0, -25.0);
        known.push_back({id, make_bearing(camera, measured, assumed_pixel_sigma, Eigen::Vector3d::Zero())});
      } else if (known.size() + fresh.size() < kFeatures) {
        fresh.push_back({id, make_bearing(camera, measured, assumed_pixel_sigma, Eigen::Vector3d::Zero())});
      }
    }
    const UpdateReport report = filter.update(camera, known);
    std::vector<LandmarkId> accepted;
    for (std::size_t i = 0; i < known.size(); ++i) {
      if (report.accepted[i]) accepted.push_back(known[i].landmark);
      if (wrong[i]) {
        ++outliers_made;
        outliers_accepted += report.accepted[i] ? 1 : 0;
      }
    }
    filter.remove(filter.convert(camera, accepted));
    for (const Measurement& measurement : fresh) {
      filter.add_landmark(measurement.landmark, camera, measurement.bearing, stamp_);
      accepted.push_back(measurement.landmark);
    }
    for (const LandmarkId id : accepted) seen_[id] = next_;
    limit_map(filter);
  }

  void limit_map(Ekf& filter) {
    if (filter.landmark_count() <= max_landmarks) return;
    std::vector<std::pair<std::size_t, LandmarkId>> by_age;
    for (const auto& [id, seen] : seen_) {
      if (filter.has(id)) by_age.emplace_back(seen, id);
    }
    std::sort(by_age.begin(), by_age.end());
    std::vector<LandmarkId> surplus;
    for (std::size_t i = 0; i < filter.landmark_count() - max_landmarks; ++i) surplus.push_back(by_age[i].second);
    filter.remove(surplus);
  }

  Noise noise_;
  MotionOptions motion_;
  std::vector<common::Pose2> path_;
  std::vector<Eigen::Vector3d> points_;
  double reach_;
  std::vector<Camera> cameras_;
  OdometryCalibration calibration_;
  std::size_t next_ = 1;
  common::Nanoseconds stamp_ = 0;
  int count_ = 0;
  std::map<LandmarkId, std::size_t> seen_;  // the step at which it was seen last
};

}  // namespace slamfuse::visual_slam::testing
