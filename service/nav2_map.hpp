// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "common/error.hpp"
#include "common/occupancy_grid.hpp"

namespace slamfuse::service {

/// Whether this is a YAML file with an image and a resolution, as read_nav2_map() takes it.
bool is_nav2_map(const std::filesystem::path& yaml);

/// Reads a map as Nav2's and ROS 1's map servers do: a YAML file with image (PGM or PNG, beside it or absolute),
/// resolution, origin, and optionally mode, negate, occupied_thresh and free_thresh (defaults trinary, 0, 0.65, 0.25).
/// Cells become 0, 100 or unknown, in mode scale those between the thresholds too.
///
/// Errors (kInvalidInput, naming the file): a file missing, cut or too large, a key missing or out of range, mode raw,
/// a turned map (origin's third number not 0: slamfuse's grids lie along their frame's axes).
common::Result<common::OccupancyGrid> read_nav2_map(const std::filesystem::path& yaml);

}  // namespace slamfuse::service
