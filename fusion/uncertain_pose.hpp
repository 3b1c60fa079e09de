// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"

namespace slamfuse::fusion {

/// A planar pose with the covariance of (x, y, theta) in the frame the pose is given in.
struct UncertainPose {
  common::Pose2 pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// (x, y, theta) of `to` minus that of `from`, the angle by the shortest turn.
Eigen::Vector3d difference(const common::Pose2& to, const common::Pose2& from);

/// Squared Mahalanobis distance of two poses whose errors are taken as independent: chi-square with three degrees of
/// freedom when both are right. Poses that share errors come out closer than that.
double squared_distance(const UncertainPose& a, const UncertainPose& b);

}  // namespace slamfuse::fusion
