// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "laser_slam/grid_map.hpp"
#include "laser_slam/motion_model_options.hpp"
#include "laser_slam/motion_predictor.hpp"
#include "laser_slam/scan_matcher.hpp"

namespace slamfuse::laser_slam {

/// Where one scan was found.
struct TrackedScan {
  ScanMatch match;                ///< the scan in the map
  common::Pose2 increment;        ///< the motion since the last scan, as matched
  bool odometry_doubted = false;  ///< the match was followed against the odometry
};

/// Follows the pose from scan to scan in one map: the online path, and the guard against odometry that jumps.
///
/// The climb starts where the prediction says. Where the odometry differs from the last matched speed, climbs from
/// there and from standstill are tried too; where the scan agrees badly or the odometry is too fast to be true, also
/// searches around all three. They win only when they are clearly likelier
/// and the robot could have moved so, see is_jump().
class ScanTracker {
 public:
  ScanTracker(const ScanMatcher& matcher, const ScanMatcherOptions& matching, const MotionModelOptions& motion)
      : matcher_(matcher), matching_(matching), motion_(motion) {}

  /// `last` is the pose at the last scan. Surfaces last seen before `old_before` [m of path] count as old.
  TrackedScan track(const GridMap& map, const std::vector<Eigen::Vector2d>& points, const common::Pose2& last,
                    const MotionPrediction& prediction, const MotionPredictor& predictor, double old_before) const;

  /// Covariance of a prediction's increment in the body frame.
  Eigen::Matrix3d covariance_of(const MotionPrediction& prediction) const;

 private:
  ScanMatcher matcher_;
  ScanMatcherOptions matching_;
  MotionModelOptions motion_;
};

}  // namespace slamfuse::laser_slam
