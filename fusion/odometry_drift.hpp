// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "common/options.hpp"
#include "fusion/uncertain_pose.hpp"

namespace slamfuse::fusion {

/// How wheel odometry goes wrong; variances grow in proportion to distance, turn and time.
struct OdometryDriftOptions {
  double position_per_metre = 0.05;
  double heading_per_metre = 0.02;
  double heading_per_turn = 0.05;
  double position_without_odometry = 0.3;
  double heading_without_odometry = 0.5;

  void describe(common::OptionVisitor& visit) {
    visit.real("position_per_metre", position_per_metre, {1e-4, 1.0}, "m / sqrt(m)",
               "Standard deviation of the position after one metre driven.");
    visit.real("heading_per_metre", heading_per_metre, {1e-4, 1.0}, "rad / sqrt(m)",
               "Standard deviation of the heading after one metre driven.");
    visit.real("heading_per_turn", heading_per_turn, {1e-4, 1.0}, "rad / sqrt(rad)",
               "Standard deviation of the heading after a turn by one radian.");
    visit.real("position_without_odometry", position_without_odometry, {1e-3, 10.0}, "m / sqrt(s)",
               "Standard deviation of the position after one second without any odometry.");
    visit.real("heading_without_odometry", heading_without_odometry, {1e-3, 10.0}, "rad / sqrt(s)",
               "Standard deviation of the heading after one second without any odometry.");
  }
};

/// The pose after a motion `step` told by odometry (in the body frame), with the covariance it has then.
/// `seconds_without_odometry` is the part of the time in which there was none, and `step` is too short by what was
/// driven then.
UncertainPose moved(const UncertainPose& before, const common::Pose2& step, double seconds_without_odometry,
                    const OdometryDriftOptions& options);

}  // namespace slamfuse::fusion
