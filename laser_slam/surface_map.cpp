// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/surface_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

namespace slamfuse::laser_slam {
namespace {

constexpr int kOccupiedPercent = 65;
constexpr std::int8_t kCertainLogOdds = 100;
constexpr double kSmallestCell = 1e-4;     // [m]; the search of a map takes memory by the cells in its step
constexpr double kFarthestCell = 1 << 30;  // cell numbers are integers
constexpr int kMask = Tile::kSide - 1;

common::Result<void> check(const common::OccupancyGrid& grid) {
  if (!(grid.resolution >= kSmallestCell) || !std::isfinite(grid.resolution)) {
    return common::invalid_input(
        fmt::format("cells are {} m wide, allowed are {} m and more", grid.resolution, kSmallestCell));
  }
  const auto cells = static_cast<std::int64_t>(grid.width) * grid.height;
  if (grid.width <= 0 || grid.height <= 0 || grid.cells.size() != static_cast<std::size_t>(cells)) {
    return common::invalid_input(fmt::format("the grid is {} x {} and has {} cells, allowed are width x height > 0",
                                             grid.width, grid.height, grid.cells.size()));
  }
  const Eigen::Vector2d end = grid.origin + Eigen::Vector2d(grid.width, grid.height) * grid.resolution;
  const double farthest = std::max(grid.origin.cwiseAbs().maxCoeff(), end.cwiseAbs().maxCoeff());
  if (!grid.origin.allFinite() || farthest > GridMap::kFarthest || farthest / grid.resolution > kFarthestCell) {
    return common::invalid_input(
        fmt::format("the grid reaches from ({}, {}) to ({}, {}), allowed is up to {} m "
                    "and {} cells",
                    grid.origin.x(), grid.origin.y(), end.x(), end.y(), GridMap::kFarthest, kFarthestCell));
  }
  return {};
}

}  // namespace

common::Result<GridMap> surface_map(const common::OccupancyGrid& grid, MapOptions options) {
  if (auto usable = check(grid); !usable) return tl::unexpected(usable.error());
  options.resolution = grid.resolution;
  GridMap map(options);
  // The map's cells are counted from the frame's origin, the grid's from a corner that may lie anywhere.
  const auto cell_of = [&](double metres) { return static_cast<int>(std::floor(metres / grid.resolution)); };
  const int first_x = cell_of(grid.origin.x());
  const int first_y = cell_of(grid.origin.y());
  if (!map.tiles().include(first_x >> Tile::kShift, first_y >> Tile::kShift, (first_x + grid.width) >> Tile::kShift,
                           (first_y + grid.height) >> Tile::kShift)) {
    return common::invalid_input(fmt::format("the grid has {} x {} cells, allowed are up to {} tiles of {} x {}",
                                             grid.width, grid.height, TileGrid::kMaxTiles, Tile::kSide, Tile::kSide));
  }
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      const std::int8_t value = grid.at(column, row);
      if (value < 0) continue;
      const double x = grid.origin.x() / grid.resolution + column + 0.5;
      const double y = grid.origin.y() / grid.resolution + row + 0.5;
      const int cell_x = static_cast<int>(std::floor(x));
      const int cell_y = static_cast<int>(std::floor(y));
      Tile& tile = map.tiles().write(cell_x >> Tile::kShift, cell_y >> Tile::kShift);
      const int cell = (cell_y & kMask) * Tile::kSide + (cell_x & kMask);
      const auto i = static_cast<std::size_t>(cell);
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
