// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace slamfuse::common {

/// How a landmark looked from one place.
struct LandmarkView {
  Eigen::Vector3d direction =
      Eigen::Vector3d::Zero();                ///< from the optical centre to the landmark, in the map's frame and unit
  std::vector<std::uint8_t> descriptor = {};  ///< of the feature there, empty where it was too near to the border
  std::vector<std::uint8_t> patch;            ///< square picture around it, 8-bit gray, row by row
};

/// A point the visual SLAM has mapped.
struct Landmark {
  std::int64_t id = 0;
  Eigen::Vector3d position =
      Eigen::Vector3d::Zero();  ///< in the visual map frame [m, or the map's own unit where nothing tells metres]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the position
  std::uint8_t gray = 0;                                 ///< brightness where it was first seen
  int observations = 0;                                  ///< accepted measurements so far
  std::vector<std::uint8_t> descriptor = {};             ///< of the feature, empty where the front end has none
  std::string object = {};                               ///< known object it is on (seed 001), empty where none
  std::vector<LandmarkView> views = {};                  ///< from different places, for finding it again
};

}  // namespace slamfuse::common
