// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/uncertain_pose.hpp"

#include <Eigen/Cholesky>

#include "common/angle.hpp"

namespace slamfuse::fusion {

Eigen::Vector3d difference(const common::Pose2& to, const common::Pose2& from) {
  return {to.x - from.x, to.y - from.y, common::angle_difference(to.theta, from.theta)};
}

double squared_distance(const UncertainPose& a, const UncertainPose& b) {
  const Eigen::Vector3d d = difference(a.pose, b.pose);
  const Eigen::Matrix3d covariance = a.covariance + b.covariance;
  return d.dot(covariance.ldlt().solve(d));
}

}  // namespace slamfuse::fusion
