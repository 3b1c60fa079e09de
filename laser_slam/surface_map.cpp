// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/surface_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slamfuse::laser_slam {
namespace {

constexpr int kOccupiedPercent = 65;
constexpr std::int8_t kCertainLogOdds = 100;
constexpr int kMask = Tile::kSide - 1;

}  // namespace

GridMap surface_map(const common::OccupancyGrid& grid, MapOptions options) {
  options.resolution = grid.resolution;
  GridMap map(options);
  if (grid.width <= 0 || grid.height <= 0) return map;
  // The map's cells are counted from the frame's origin, the grid's from a corner that may lie anywhere.
  const auto cell_of = [&](double metres) { return static_cast<int>(std::floor(metres / grid.resolution)); };
  const int first_x = cell_of(grid.origin.x());
  const int first_y = cell_of(grid.origin.y());
  if (!map.tiles().include(first_x >> Tile::kShift, first_y >> Tile::kShift, (first_x + grid.width) >> Tile::kShift,
                           (first_y + grid.height) >> Tile::kShift))
    return map;
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      const std::int8_t value = grid.at(column, row);
      if (value < 0) continue;
      const double x = grid.origin.x() / grid.resolution + column + 0.5;
      const double y = grid.origin.y() / grid.resolution + row + 0.5;
      const int cell_x = static_cast<int>(std::floor(x));
      const int cell_y = static_cast<int>(std::floor(y));
      Tile& tile = map.tiles().write(cell_x >> Tile::kShift, cell_y >> Tile::kShift);
      const auto i = static_cast<std::size_t>((cell_y & kMask) * Tile::kSide + (cell_x & kMask));
      if (value < kOccupiedPercent) {
        tile.log_odds[i] = kCertainLogOdds;
        continue;
      }
      tile.log_odds[i] = -kCertainLogOdds;
      tile.occupied[static_cast<std::size_t>(cell_y & kMask)] |= 1u << (cell_x & kMask);
      const auto offset = [](double within) {
        return static_cast<std::int16_t>(std::clamp(within * Endpoints::kOffsetUnits, -30000.0, 30000.0));
      };
      tile.endpoints[i] = {offset(x - cell_x - 0.5), offset(y - cell_y - 0.5),
                           static_cast<std::uint16_t>(GridMap::kTrustedHits), 0};
    }
  }
  return map;
}

}  // namespace slamfuse::laser_slam
