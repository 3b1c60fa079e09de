// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/occupancy_grid.hpp"

namespace slamfuse::service {

/// A part of an occupancy grid as a picture.
struct GridPng {
  std::string base64;  ///< of a PNG: free white, occupied black, unknown transparent; the top row has the largest y
  double x_min = 0.0;  ///< the rectangle it covers in the map frame [m]
  double x_max = 0.0;
  double y_min = 0.0;
  double y_max = 0.0;
};

/// The smallest rectangle of the grid that holds every known cell, at most `max_side` pixels high and wide: larger ones
/// are thinned by whole factors, a pixel showing the most occupied of its cells. Nothing when every cell is unknown.
std::optional<GridPng> grid_to_png(const common::OccupancyGrid& grid, int max_side);

/// RFC 4648 base64 with padding.
std::string to_base64(std::string_view bytes);

}  // namespace slamfuse::service
