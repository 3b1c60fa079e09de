// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <istream>
#include <string>
#include <string_view>

#include "common/error.hpp"
#include "common/occupancy_grid.hpp"

namespace slamfuse::service {

/// A grid as Nav2's map server reads it: a binary PGM, top row first (y upwards), in trinary values 0 occupied, 254
/// free, 205 unknown, and a YAML file beside it. The image goes to `take` piece by piece, so that it need not be held.
void grid_to_pgm(const common::OccupancyGrid& grid, const std::function<void(std::string_view)>& take);

/// The YAML file that belongs to the image named `image`.
std::string grid_to_yaml(const common::OccupancyGrid& grid, const std::string& image);

/// Reads both back; cells become 0, 100 or unknown. Takes the grid's memory and a row. Errors (kInvalidInput): not such
/// files, cut or too long images, sizes or numbers that make no sense.
common::Result<common::OccupancyGrid> grid_from_files(std::istream& pgm, const std::string& yaml);

}  // namespace slamfuse::service
