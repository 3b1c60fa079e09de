// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/angle.hpp"
#include "common/pose_estimate.hpp"
#include "common/sensor_message.hpp"
#include "fusion/fusion.hpp"
#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {

/// A drive round a flat as the fusion sees it: odometry at 20 Hz with wrong wheel sizes, laser poses at 5 Hz with 2 cm
/// of noise, visual poses at 4 Hz in their own frame with 5 cm of noise. Truth is kept for the assertions only.
class SimulatedDrive {
 public:
  explicit SimulatedDrive(std::uint64_t seed = 1) : noise_(seed) {}

  static constexpr common::Nanoseconds kStep = common::kNanosecondsPerSecond / 20;

  common::Nanoseconds stamp(int step) const { return kTestStart + step * kStep; }
  double seconds(int step) const { return common::to_seconds(step * kStep); }

  /// T_map_base in the laser's map frame: 0.4 m/s along two waves.
  common::Pose2 truth(int step) const {
    const double t = 0.1 * seconds(step);
    const auto at = [](double u) { return Eigen::Vector2d(3.0 * std::sin(u), 4.0 * std::sin(0.61 * u + 0.4)); };
    const Eigen::Vector2d ahead = at(t + 1e-5) - at(t - 1e-5);
    return {at(t).x(), at(t).y(), std::atan2(ahead.y(), ahead.x())};
  }

  common::WheelOdometry odometry(int step) {
    if (step > 0) {
      common::Pose2 motion = truth(step - 1).inverse() * truth(step);
      motion.x *= 1.02;
      motion.theta = motion.theta * 0.97 + 0.0003 * noise_.normal();
      T_odom_base_ = T_odom_base_ * motion;
    }
    common::WheelOdometry message;
    message.stamp = stamp(step);
    message.pose = T_odom_base_;
    return message;
  }

  common::PoseEstimate laser(int step) {
    common::PoseEstimate estimate;
    estimate.stamp = stamp(step);
    estimate.source = common::PoseSource::kLaser;
    estimate.pose = disturbed(truth(step), 0.02, 0.005);
    estimate.covariance = Eigen::Vector3d(4e-4, 4e-4, 2.5e-5).asDiagonal();
    return estimate;
  }

  common::PoseEstimate visual(int step) {
    common::PoseEstimate estimate;
    estimate.stamp = stamp(step);
    estimate.source = common::PoseSource::kVisual;
    const common::Pose2 pose = disturbed(truth(step), 0.05, 0.01);
    const Eigen::Vector2d position = laser_from_visual().inverse() * pose.translation();
    estimate.pose = {position.x(), position.y(),
                     common::normalize_angle(pose.theta - take_apart(laser_from_visual()).rotation)};
    const double variance = 0.05 * 0.05 / 4.0;
    estimate.covariance = Eigen::Vector3d(variance, variance, 1e-4).asDiagonal();
    return estimate;
  }

  static PlanarAffine laser_from_visual() { return stretched_map(40.0, 2.0, 2.0, 1.0, -3.0); }

 private:
  common::Pose2 disturbed(const common::Pose2& pose, double position, double heading) {
    return {pose.x + position * noise_.normal(), pose.y + position * noise_.normal(),
            common::normalize_angle(pose.theta + heading * noise_.normal())};
  }

  TestNoise noise_;
  common::Pose2 T_odom_base_{-2.0, 7.0, 1.0};
};

}  // namespace slamfuse::fusion
