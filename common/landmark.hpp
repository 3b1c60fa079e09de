// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace slamfuse::common {

/// A point the visual SLAM has mapped.
struct Landmark {
  std::int64_t id = 0;
  Eigen::Vector3d position =
      Eigen::Vector3d::Zero();  ///< in the visual map frame [m, or its own unit without odometry]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the position
  std::uint8_t gray = 0;                                 ///< brightness where it was first seen
  int observations = 0;                                  ///< accepted measurements so far
  std::vector<std::uint8_t> descriptor;                  ///< of the feature, empty where the front end has none
};

}  // namespace slamfuse::common
