// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "laser_slam/motion_model.hpp"
#include "laser_slam/motion_predictor.hpp"
#include "laser_slam/particle_filter.hpp"
#include "laser_slam/scan_tracker.hpp"

namespace slamfuse::laser_slam {

/// Adds up the motion from scan to scan between two filter updates.
class MotionAccumulator {
 public:
  explicit MotionAccumulator(const MotionModelOptions& options) : options_(options) {}

  void clear();
  /// One step: what was predicted and how the scan was found.
  void add(const MotionPrediction& prediction, const TrackedScan& tracked);

  /// By the matches alone.
  const common::Pose2& matched() const { return matched_; }
  const Travel& matched_travel() const { return matched_travel_; }
  /// Uncertainty of the motion in the body frame at its end, before any scan is looked at.
  Eigen::Matrix3d covariance() const;

  /// What the filter is told. Where the odometry was not to be believed the match stands in for it, as uncertain as a
  /// prediction.
  MotionSinceUpdate believed() const;
  /// Everything it may have been: as believed, and as predicted where that was doubted.
  std::vector<MotionSinceUpdate> candidates() const;

 private:
  MotionModelOptions options_;
  common::Pose2 matched_;
  common::Pose2 believed_;
  common::Pose2 predicted_;
  Travel matched_travel_;
  Travel odometry_travel_;                                          // where it is believed
  Travel predicted_travel_;                                         // whether or not
  Eigen::Matrix3d predicted_covariance_ = Eigen::Matrix3d::Zero();  // of what was believed without odometry
  bool doubted_ = false;
};

}  // namespace slamfuse::laser_slam
