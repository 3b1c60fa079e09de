// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/options.hpp"
#include "common/slam_module.hpp"
#include "service/thinned_series.hpp"

namespace slamfuse::service {

/// The sensors whose messages are poses of another SLAM system.
inline const std::string kLaserPose = "laser_pose";
inline const std::string kVisualPose = "visual_pose";

/// How poses are taken that come without a covariance, or with one that is zero.
struct ExternalPoseOptions {
  double position_sigma = 0.05;
  double heading_sigma = 0.02;
  int poses = 20000;

  void describe(common::OptionVisitor& visit) {
    visit.real("position_sigma", position_sigma, {1e-4, 10.0}, "m (or the map's unit)",
               "Standard deviation of their positions.");
    visit.real("heading_sigma", heading_sigma, {1e-4, 1.0}, "rad", "Standard deviation of their headings.");
    visit.integer("poses", poses, {100, 10000000}, "poses", "Kept of the path; longer ones are thinned evenly.");
  }
};

/// Poses of another SLAM system in the place of one half. A pose in another frame than the one before begins a new map
/// epoch. Nobody can be told anything: commands do nothing.
class ExternalPoses : public common::SlamModule {
 public:
  /// `sensor` is kLaserPose or kVisualPose.
  ExternalPoses(std::string sensor, const ExternalPoseOptions& options)
      : sensor_(std::move(sensor)), options_(options), path_(static_cast<std::size_t>(options.poses)) {}

  common::PoseSource source() const override;
  bool wants(const common::SensorMessage& message) const override;
  common::ProcessResult process(const common::SensorMessage& message) override;
  void execute(const common::Command& /*command*/) override {}
  /// The poses of the newest epoch as they came, thinned where they are many.
  common::Trajectory2 final_trajectory() const override { return path_.items(); }

 private:
  const std::string sensor_;
  const ExternalPoseOptions options_;
  std::string frame_;
  std::uint32_t epoch_ = 0;
  ThinnedSeries<common::StampedPose2> path_;
};

}  // namespace slamfuse::service
