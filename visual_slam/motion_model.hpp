// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "visual_slam/options.hpp"
#include "visual_slam/state.hpp"

namespace slamfuse::visual_slam {

/// Systematic errors of the wheel odometry, three numbers of the state: the true distance is (1 + a) times the measured
/// one, the true turn is (1 + b) times the measured one plus c for each metre driven.
using OdometryCalibration = Eigen::Vector3d;

/// Jacobian of exp_se2 in (x, y, theta) of the result with respect to the twist.
Eigen::Matrix3d exp_se2_jacobian(const Eigen::Vector3d& twist);

/// An odometry increment with the systematic errors taken out, and its derivatives.
struct CalibratedIncrement {
  common::Pose2 increment;
  Eigen::Matrix3d wrt_calibration;
  Eigen::Matrix3d noise;  ///< covariance of (x, y, theta) of the increment
};
CalibratedIncrement calibrate_increment(const common::Pose2& measured, const OdometryCalibration& calibration,
                                        const MotionOptions& options);

/// EKF prediction (seed 001 section 3, step 1): the pose block moves by the odometry increment, its covariance grows by
/// the noise of the increment and by what is not known of the calibration.
void predict_pose(State& state, BlockId robot, BlockId calibration, const common::Pose2& measured,
                  const MotionOptions& options);

}  // namespace slamfuse::visual_slam
