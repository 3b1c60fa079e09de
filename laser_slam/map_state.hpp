// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/error.hpp"
#include "common/occupancy_grid.hpp"
#include "common/pose2.hpp"
#include "laser_slam/grid_map.hpp"

namespace slamfuse::laser_slam {

/// What is needed to continue mapping.
struct MapState {
  common::Pose2 pose;        ///< T_map_base when it was saved
  double path_length = 0.0;  ///< travelled so far [m]
  GridMap map;
};

/// The map as an occupancy grid, cut to what has been seen. Empty (width 0) for an empty map. Made through
/// mrpt::maps::COccupancyGridMap2D, whose cell scale the tiles use.
common::OccupancyGrid to_occupancy_grid(const GridMap& map);

/// A state as bytes: magic "SFLASER1", format version, length and CRC-32 of the payload, then the payload through
/// MRPT's serialisation: pose, path length, cell size and the tiles that exist.
std::string serialize_state(const MapState& state);

/// Reads such bytes. Errors (kInvalidInput): other magic or version, length or checksum wrong, a number that is not
/// finite, another cell size than `options` ask for, more tiles than the bytes can hold or a map may span, a pose
/// outside any map.
common::Result<MapState> parse_state(const std::string& bytes, const MapOptions& options);

}  // namespace slamfuse::laser_slam
