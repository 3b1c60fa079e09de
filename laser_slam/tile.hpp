// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

namespace slamfuse::laser_slam {

/// Running mean of the beam endpoints that fell into a cell, in 8 bytes.
struct Endpoints {
  std::int16_t offset_x = 0;    ///< mean minus cell centre, in units of resolution / kOffsetUnits
  std::int16_t offset_y = 0;    ///< the same along y
  std::uint16_t hits = 0;       ///< endpoints so far, saturating
  std::uint16_t last_path = 0;  ///< path length of the robot at the last of them [kPathUnit m], see GridMap

  static constexpr double kOffsetUnits = 60000.0;  // +-half a cell fits 16 bits
  static constexpr double kPathUnit = 0.25;        // 16 km fit 16 bits
};

/// A square of kSide x kSide cells: the unit in which particles share and copy their maps.
struct Tile {
  static constexpr int kShift = 5;
  static constexpr int kSide = 1 << kShift;
  static constexpr int kCells = kSide * kSide;

  /// Log-odds of each cell in MRPT's scale and sign (CLogOddsGridMap2D<int8_t>: negative is occupied), row-major.
  std::array<std::int8_t, kCells> log_odds{};
  /// One bit a cell, one word a row: has endpoints and is likely enough to be occupied. Lets matching skip the rest.
  std::array<std::uint32_t, kSide> occupied{};
  std::array<Endpoints, kCells> endpoints{};
};

}  // namespace slamfuse::laser_slam
