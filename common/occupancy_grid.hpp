// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace slamfuse::common {

/// An occupancy grid in the map frame, as ROS's nav_msgs/OccupancyGrid: row-major from the cell at the origin, x along
/// the row. The origin is the corner of cell (0, 0), not its centre; the axes are those of the map frame.
struct OccupancyGrid {
  static constexpr std::int8_t kUnknown = -1;

  double resolution = 0.05;                          ///< side of a cell [m]
  int width = 0;                                     ///< cells along x
  int height = 0;                                    ///< cells along y
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< lower left corner [m]
  std::vector<std::int8_t> cells;                    ///< 0 free .. 100 occupied [percent], -1 unknown

  std::int8_t at(int column, int row) const {
    return cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
  }
};

}  // namespace slamfuse::common
