// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/tile_grid.hpp"

#include <algorithm>
#include <cstdint>

namespace slamfuse::laser_slam {
namespace {

constexpr int kGrowth = 8;  // tiles added beyond what is asked, so that growing stays rare

std::size_t area(std::int64_t width, std::int64_t height) { return static_cast<std::size_t>(width * height); }

}  // namespace

bool TileGrid::include(int first_x, int first_y, int last_x, int last_y) {
  if (width_ > 0 && first_x >= min_x_ && first_y >= min_y_ && last_x < min_x_ + width_ && last_y < min_y_ + height_) {
    return true;
  }
  TileGrid grown;
  const bool had = width_ > 0;
  for (const int growth : {kGrowth, 0}) {
    const auto low = [&](int first, int old) { return had && first >= old ? old : first - growth; };
    const auto high = [&](int last, int old_end) { return had && last < old_end ? old_end : last + 1 + growth; };
    grown.min_x_ = low(first_x, min_x_);
    grown.min_y_ = low(first_y, min_y_);
    grown.width_ = high(last_x, min_x_ + width_) - grown.min_x_;
    grown.height_ = high(last_y, min_y_ + height_) - grown.min_y_;
    if (area(grown.width_, grown.height_) <= kMaxTiles) break;
  }
  if (area(grown.width_, grown.height_) > kMaxTiles) return false;
  grown.tiles_.resize(static_cast<std::size_t>(grown.width_) * static_cast<std::size_t>(grown.height_));
  for (int y = min_y_; y < min_y_ + height_; ++y) {
    for (int x = min_x_; x < min_x_ + width_; ++x) grown.tiles_[grown.index(x, y)] = std::move(tiles_[index(x, y)]);
  }
  *this = std::move(grown);
  return true;
}

std::size_t TileGrid::count() const {
  return static_cast<std::size_t>(
      std::count_if(tiles_.begin(), tiles_.end(), [](const CowPtr<Tile>& tile) { return tile.get() != nullptr; }));
}

std::size_t TileGrid::count_shared(const TileGrid& other) const {
  std::size_t shared = 0;
  for (int y = min_y_; y < min_y_ + height_; ++y) {
    for (int x = min_x_; x < min_x_ + width_; ++x) {
      const CowPtr<Tile>* theirs = other.find_slot(x, y);
      if (theirs && tiles_[index(x, y)].shares_with(*theirs)) ++shared;
    }
  }
  return shared;
}

}  // namespace slamfuse::laser_slam
