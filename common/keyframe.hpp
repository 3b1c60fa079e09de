// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/pose3.hpp"
#include "common/time.hpp"

namespace slamfuse::common {

/// Where a landmark was seen in a picture.
struct KeyframeObservation {
  std::int64_t landmark = 0;                        ///< Landmark::id
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< as measured [px], pixel centres at whole numbers
};

/// A picture the visual SLAM remembers, with the pose it was taken from and what it showed of the map.
struct Keyframe {
  std::string camera;     ///< sensor name
  Nanoseconds stamp = 0;  ///< of the image
  Pose3 T_map_camera;     ///< optical frame in the visual map [m, or the map's own unit where nothing tells metres]
  std::vector<KeyframeObservation> observations;
};

}  // namespace slamfuse::common
