// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <variant>

#include <Eigen/Core>

#include "common/pose2.hpp"

namespace slamfuse::common {

/// Put the estimate at a pose: particles are drawn around it, a filter's pose is replaced. In the receiver's own map
/// frame.
struct SetPose {
  Pose2 pose;                                                ///< T_map_base
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of (x, y, theta) [m^2, m rad, rad^2]
};

/// Search the whole map for the pose.
struct Relocalise {};

/// Forget the map and start a new epoch.
struct Reset {};

/// What the fusion (or a user, through DDS) may ask of a SLAM module.
using Command = std::variant<SetPose, Relocalise, Reset>;

}  // namespace slamfuse::common
