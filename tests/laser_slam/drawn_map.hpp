// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>

#include "common/occupancy_grid.hpp"
#include "laser_slam/laser_localization.hpp"
#include "synthetic_room.hpp"

namespace slamfuse::laser_slam::testing {

/// Walls as cells, the space within the outer box free: as a perfect mapper would draw it.
inline common::OccupancyGrid draw(const Walls& walls, double x0, double y0, double x1, double y1) {
  common::OccupancyGrid grid;
  grid.resolution = 0.05;
  grid.origin = {x0 - 0.2, y0 - 0.2};
  grid.width = static_cast<int>((x1 - x0 + 0.4) / 0.05);
  grid.height = static_cast<int>((y1 - y0 + 0.4) / 0.05);
  grid.cells.assign(static_cast<std::size_t>(grid.width * grid.height), common::OccupancyGrid::kUnknown);
  const auto at = [&](double x, double y) -> std::int8_t& {
    const int column = static_cast<int>((x - grid.origin.x()) / 0.05);
    const int row = static_cast<int>((y - grid.origin.y()) / 0.05);
    return grid.cells[static_cast<std::size_t>(row * grid.width + column)];
  };
  for (double x = x0; x < x1; x += 0.04) {
    for (double y = y0; y < y1; y += 0.04) at(x, y) = 0;
  }
  for (const auto& [a, b] : walls) {
    const int steps = static_cast<int>((b - a).norm() / 0.01);
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector2d p = a + (b - a) * (static_cast<double>(i) / std::max(1, steps));
      at(p.x(), p.y()) = 100;
    }
  }
  return grid;
}

inline LocalizationMap room_map() { return {"room", draw(room(), -3.03, -2.02, 5.02, 4.01), {}}; }

}  // namespace slamfuse::laser_slam::testing
