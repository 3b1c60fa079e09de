// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/ekf.hpp"
#include "visual_slam/motion_model.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// A whole drive at once: all poses, the odometry's systematic errors and all landmarks that fit all bearings and all
/// odometry increments best (nonlinear least squares, linearised anew until nothing moves). Not in the seeds.
///
/// A filter linearises each bearing once, where it believed to be when it came. What it took for the depth of a
/// landmark seen for the first time, and the way it drove meanwhile, stay in the map. Here they do not, at the price of
/// keeping every bearing. Poses are planar, cameras anywhere on the robot.
class BatchAdjustment {
 public:
  struct Result {
    std::vector<common::Pose2> poses;
    std::map<LandmarkId, Eigen::Vector3d> landmarks;  ///< [m]
    OdometryCalibration calibration = OdometryCalibration::Zero();
    int wrong = 0;      ///< bearings that fit nothing and were left out
    double cost = 0.0;  ///< half the sum of squares over the noise, large residuals counting less (Huber)
    int iterations = 0;
  };

  explicit BatchAdjustment(const MotionOptions& options) : options_(options) {}

  /// The first pose, which stays.
  void start(const common::Pose2& pose) { poses_ = {pose}; }
  /// The next pose: the odometry since the one before, and where the robot is believed to be now.
  void add_pose(const common::Pose2& odometry, const common::Pose2& believed);
  /// Changes where the robot was at a pose, by what is believed now.
  void believe(std::size_t pose, const common::Pose2& believed) { poses_[pose] = believed; }
  std::size_t poses() const { return poses_.size(); }
  /// A bearing from the newest pose. The camera must outlive this.
  void add_bearing(const Camera& camera, LandmarkId landmark, const Bearing& bearing);

  /// Adjusts everything from the poses as believed and these places of the landmarks [m]; bearings of others are left
  /// out, and so are landmarks with fewer than `least_bearings`. Bearings that do not fit what all together say are
  /// left out in a second round. Empty when the equations cannot be solved.
  std::optional<Result> adjust(const std::map<LandmarkId, Eigen::Vector3d>& landmarks, int least_bearings = 3) const;

 private:
  class Problem;
  struct Sight {
    std::size_t pose = 0;
    const Camera* camera = nullptr;
    LandmarkId landmark = 0;
    Bearing bearing;
  };

  MotionOptions options_;
  std::vector<common::Pose2> poses_;
  std::vector<common::Pose2> odometry_;  // from each pose to the next
  std::vector<Sight> sights_;
};

}  // namespace slamfuse::visual_slam
