// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/uncertain_pose.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

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

UncertainPose intersect(const UncertainPose& a, const UncertainPose& b) {
  const Eigen::Matrix3d information_a = a.covariance.inverse();
  const Eigen::Matrix3d information_b = b.covariance.inverse();
  const auto mixed = [&](double weight) -> Eigen::Matrix3d {
    return weight * information_a + (1.0 - weight) * information_b;
  };
  // The determinant of a mean of matrices is log-concave in the weight: ternary search finds its one maximum.
  constexpr int kSteps = 40;
  double low = 0.0;
  double high = 1.0;
  for (int n = 0; n < kSteps; ++n) {
    const double left = low + (high - low) / 3.0;
    const double right = high - (high - low) / 3.0;
    if (mixed(left).determinant() < mixed(right).determinant()) {
      low = left;
    } else {
      high = right;
    }
  }
  const double weight = 0.5 * (low + high);
  if (mixed(0.0).determinant() >= mixed(weight).determinant()) return b;
  if (mixed(1.0).determinant() >= mixed(weight).determinant()) return a;

  const Eigen::Matrix3d covariance = mixed(weight).inverse();
  const Eigen::Vector3d step = covariance * ((1.0 - weight) * information_b * difference(b.pose, a.pose));
  return {{a.pose.x + step.x(), a.pose.y + step.y(), common::normalize_angle(a.pose.theta + step.z())},
          0.5 * (covariance + covariance.transpose())};
}

}  // namespace slamfuse::fusion
