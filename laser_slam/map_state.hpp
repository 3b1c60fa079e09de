// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

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

/// Larger maps are neither saved nor loaded: 0.67 km2 seen at 5 cm, 2.4 GB in memory. Bounds what a hostile file can
/// take.
inline constexpr std::uint32_t kMaxSavedTiles = std::uint32_t{1} << 18;

/// A state as bytes: magic "SFLASER1", format version (2), length and CRC-32 of what follows, then the payload,
/// compressed by zlib as it is made: through MRPT's serialisation pose, path length, cell size and the tiles that
/// exist. Beside the bytes it takes half a megabyte, however large the map. Errors (kFailed): more than kMaxSavedTiles.
common::Result<std::string> serialize_state(const MapState& state);

/// Reads such bytes, and those of version 1 (the same payload, not compressed); beside the map it takes half a megabyte
/// and 8 bytes a tile. Errors (kInvalidInput): other magic or version, length or checksum wrong, bytes missing or left
/// over, a number that is not finite, another cell size than `options` ask for, more tiles than kMaxSavedTiles, the
/// bytes can hold or a map may span, tiles out of order, a pose outside any map.
common::Result<MapState> parse_state(std::string_view bytes, const MapOptions& options);

}  // namespace slamfuse::laser_slam
