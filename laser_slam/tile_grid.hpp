// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "laser_slam/cow_ptr.hpp"
#include "laser_slam/tile.hpp"

namespace slamfuse::laser_slam {

/// A rectangle of tiles that grows as it is written to. Copies share their tiles until one of them writes.
class TileGrid {
 public:
  /// Of the rectangle: 1.6 km x 1.6 km at 5 cm, or any other shape of that area. Bounds the memory of a map that is
  /// stretched by a pose gone astray: 8 MB a particle for the rectangle, 1 GB for the map as a dense grid.
  static constexpr std::size_t kMaxTiles = std::size_t{1} << 20;

  /// Tile coordinates: cell coordinates / Tile::kSide, rounded down.
  int min_x() const { return min_x_; }
  int min_y() const { return min_y_; }
  int width() const { return width_; }
  int height() const { return height_; }

  /// The tile at tile coordinates, null where there is none.
  const Tile* find(int x, int y) const {
    const CowPtr<Tile>* slot = find_slot(x, y);
    return slot ? slot->get() : nullptr;
  }

  /// The tile to write to, made or copied as needed. The coordinates must be inside the rectangle, see include().
  Tile& write(int x, int y) { return tiles_[index(x, y)].write(); }

  /// Grows the rectangle to hold these tile coordinates, both ends included; by a margin more where kMaxTiles leaves
  /// room for it. False, with nothing changed, when they would take more than kMaxTiles.
  [[nodiscard]] bool include(int first_x, int first_y, int last_x, int last_y);

  /// How many tiles exist, and how many of them `other` holds too (in memory).
  std::size_t count() const;
  std::size_t count_shared(const TileGrid& other) const;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - min_y_) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x - min_x_);
  }
  const CowPtr<Tile>* find_slot(int x, int y) const {
    if (x < min_x_ || y < min_y_ || x >= min_x_ + width_ || y >= min_y_ + height_) return nullptr;
    return &tiles_[index(x, y)];
  }

  int min_x_ = 0;
  int min_y_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::vector<CowPtr<Tile>> tiles_;
};

}  // namespace slamfuse::laser_slam
