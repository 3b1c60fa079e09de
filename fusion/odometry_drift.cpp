// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/odometry_drift.hpp"

#include <cmath>

namespace slamfuse::fusion {
namespace {

double square(double value) { return value * value; }

}  // namespace

UncertainPose moved(const UncertainPose& before, const common::Pose2& step, double seconds_without_odometry,
                    const OdometryDriftOptions& options) {
  const double distance = step.translation().norm();
  const double turn = std::abs(step.theta);
  const double position = square(options.position_per_metre) * distance +
                          square(options.position_without_odometry) * seconds_without_odometry;
  const double heading = square(options.heading_per_metre) * distance + square(options.heading_per_turn) * turn +
                         square(options.heading_without_odometry) * seconds_without_odometry;
  const Eigen::Matrix3d drift = Eigen::Vector3d(position, position, heading).asDiagonal();

  const common::ComposeJacobians jacobians = common::compose_jacobians(before.pose, step);
  UncertainPose after;
  after.pose = before.pose * step;
  after.covariance = jacobians.wrt_a * before.covariance * jacobians.wrt_a.transpose() +
                     jacobians.wrt_b * drift * jacobians.wrt_b.transpose();
  return after;
}

}  // namespace slamfuse::fusion
