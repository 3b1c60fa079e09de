// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/error.hpp"
#include "common/occupancy_grid.hpp"
#include "laser_slam/grid_map.hpp"

namespace slamfuse::laser_slam {

/// A map to match scans in, made from a finished occupancy grid: every occupied cell becomes a surface point at its
/// centre. Cells of 65 percent and more are occupied. Coarser than a map that was drawn from scans, whose cells know
/// where in them the beams ended. Errors (kInvalidInput, the reason): a cell size below 0.1 mm or not finite, not as
/// many cells as width and height ask for, no cell at all, a corner farther than GridMap::kFarthest or 2^30 cells from
/// the origin, more area than TileGrid::kMaxTiles hold.
common::Result<GridMap> surface_map(const common::OccupancyGrid& grid, MapOptions options);

}  // namespace slamfuse::laser_slam
