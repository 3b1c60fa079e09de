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

  /// Grows the rectangle to hold these tile coordinates, both ends included.
  void include(int first_x, int first_y, int last_x, int last_y);

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
