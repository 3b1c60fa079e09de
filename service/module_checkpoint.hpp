// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/calibration.hpp"
#include "common/keyframe.hpp"
#include "common/landmark.hpp"
#include "common/occupancy_grid.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::service {

/// What a module knew at a moment, enough to save its map. What it does not have is empty.
struct ModuleCheckpoint {
  std::optional<common::OccupancyGrid> grid = {};
  std::string laser_state = {};  ///< to continue from
  std::vector<common::Landmark> landmarks = {};
  std::vector<common::Keyframe> keyframes = {};
  std::map<std::string, common::CameraCalibration> cameras = {};  ///< that took them
  common::Trajectory2 path = {};                                  ///< as believed now
};

}  // namespace slamfuse::service
