// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "laser_slam/motion_model_options.hpp"
#include "laser_slam/random_stream.hpp"

namespace slamfuse::laser_slam {

/// How far and how much the robot moved: what the uncertainty of odometry grows with.
struct Travel {
  double distance = 0.0;  ///< [m]
  double turn = 0.0;      ///< sum of |turns| [rad]

  Travel& operator+=(const common::Pose2& increment);
};

/// Covariance of an odometry increment, in the body frame at its end: isotropic in position, see MotionModelOptions.
/// (Thrun, Burgard, Fox: Probabilistic Robotics, section 5.4, with its three elementary motions taken together.)
Eigen::Matrix3d odometry_covariance(const Travel& travel, const MotionModelOptions& options);

/// Covariance of an increment predicted from the last speed over `seconds`, in the body frame at its end.
Eigen::Matrix3d prediction_covariance(double seconds, const MotionModelOptions& options);

/// Whether an odometry increment over `seconds` is too fast to be true.
bool is_jump(const common::Pose2& increment, double seconds, const MotionModelOptions& options);

/// A covariance given in the body frame at `pose`, in the frame that pose is given in (x, y, theta coordinates).
Eigen::Matrix3d to_parent_frame(const Eigen::Matrix3d& body_covariance, const common::Pose2& pose);

/// A pose drawn from the normal distribution around `mean` with `covariance` in (x, y, theta) coordinates.
common::Pose2 draw_pose(const common::Pose2& mean, const Eigen::Matrix3d& covariance, RandomStream& random);

}  // namespace slamfuse::laser_slam
