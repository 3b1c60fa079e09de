// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/grid_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include <mrpt/maps/CLogOddsGridMap2D.h>

namespace slamfuse::laser_slam {
namespace {

using LogOdds = mrpt::maps::CLogOddsGridMap2D<std::int8_t>;

constexpr int kMask = Tile::kSide - 1;
constexpr double kOffsetUnit = 1.0 / Endpoints::kOffsetUnits;  // [cells]
constexpr int kRayMargin = 1;  // cells before an endpoint a beam does not clear: the wall itself at a slant

/// The cell that holds a coordinate [cells]: std::floor, in a few instructions.
int cell_at(double coordinate) {
  // No map reaches so far; the bound only keeps the number an int, whatever pose is asked about.
  constexpr double kFarthestCell = 1 << 30;
  const double bounded = std::min(std::max(coordinate, -kFarthestCell), kFarthestCell);
  const int towards_zero = static_cast<int>(bounded);
  return towards_zero - (bounded < towards_zero ? 1 : 0);
}

/// When a cell was last seen, on seeing it again. After a long absence it comes only halfway: a place that comes into
/// view bit by bit is then still old when the robot stands in it, which is what closing a loop is told by.
std::uint16_t seen_again(std::uint16_t last_path, std::uint16_t path) {
  constexpr int kAbsence = static_cast<int>(5.0 / Endpoints::kPathUnit);  // 5 m
  const int gap = path - last_path;
  return gap <= kAbsence ? path : static_cast<std::uint16_t>(last_path + gap / 2);
}

std::int8_t integer_log_odds(double probability) {
  static mrpt::maps::CLogOddsGridMapLUT<std::int8_t> table;
  return table.p2l(static_cast<float>(probability));
}

/// What one observation changes a cell by: never nothing, however weak it is.
std::int8_t step_of(double probability) { return std::max<std::int8_t>(1, integer_log_odds(probability)); }

std::size_t cell_index(int cell_x, int cell_y) {
  return static_cast<std::size_t>(cell_y & kMask) * Tile::kSide + static_cast<std::size_t>(cell_x & kMask);
}

void set_occupied(Tile& tile, int cell_x, int cell_y, bool occupied) {
  const std::uint32_t bit = 1u << (cell_x & kMask);
  std::uint32_t& row = tile.occupied[static_cast<std::size_t>(cell_y & kMask)];
  row = occupied ? row | bit : row & ~bit;
}

/// Calls visit(tile, local x, local y) for every occupied cell of a square, row by row.
template <class Visit>
void for_each_occupied(const TileGrid& tiles, int center_x, int center_y, int reach, const Visit& visit) {
  const int first_x = center_x - reach;
  const int first_y = center_y - reach;
  const int side = 2 * reach + 1;
  const int local_x = first_x & kMask;
  const int tile_x = first_x >> Tile::kShift;
  const std::uint32_t window = (1u << side) - 1u;
  const bool crosses = local_x + side > Tile::kSide;
  const Tile* left = nullptr;
  const Tile* right = nullptr;
  for (int row = 0; row < side; ++row) {
    const int cell_y = first_y + row;
    const int local_y = cell_y & kMask;
    if (row == 0 || local_y == 0) {
      left = tiles.find(tile_x, cell_y >> Tile::kShift);
      right = crosses ? tiles.find(tile_x + 1, cell_y >> Tile::kShift) : nullptr;
    }
    std::uint32_t bits = 0;
    if (left) bits = left->occupied[static_cast<std::size_t>(local_y)] >> local_x;
    if (right) bits |= right->occupied[static_cast<std::size_t>(local_y)] << (Tile::kSide - local_x);
    for (bits &= window; bits != 0; bits &= bits - 1) {
      const int x = local_x + std::countr_zero(bits);
      const Tile* tile = x < Tile::kSide ? left : right;
      if (tile) visit(*tile, first_x + std::countr_zero(bits), cell_y);
    }
  }
}

/// Calls visit(x, y) for the cells from one point to another (Amanatides and Woo 1987), in units of cells, without the
/// last one.
template <class Visit>
void walk_cells(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Visit& visit) {
  int x = cell_at(from.x());
  int y = cell_at(from.y());
  const int last_x = cell_at(to.x());
  const int last_y = cell_at(to.y());
  const Eigen::Vector2d direction = to - from;
  const int step_x = direction.x() > 0.0 ? 1 : -1;
  const int step_y = direction.y() > 0.0 ? 1 : -1;
  const double delta_x = direction.x() != 0.0 ? 1.0 / std::abs(direction.x()) : HUGE_VAL;
  const double delta_y = direction.y() != 0.0 ? 1.0 / std::abs(direction.y()) : HUGE_VAL;
  double next_x = direction.x() != 0.0 ? (x + (step_x > 0 ? 1 : 0) - from.x()) / direction.x() : HUGE_VAL;
  double next_y = direction.y() != 0.0 ? (y + (step_y > 0 ? 1 : 0) - from.y()) / direction.y() : HUGE_VAL;
  for (int steps = std::abs(last_x - x) + std::abs(last_y - y); steps > 0; --steps) {
    visit(x, y);
    if (next_x < next_y) {
      x += step_x;
      next_x += delta_x;
    } else {
      y += step_y;
      next_y += delta_y;
    }
  }
}

/// The tile last written to: most cells of a beam lie in the tile of the one before.
class WrittenTile {
 public:
  explicit WrittenTile(TileGrid& tiles) : tiles_(tiles) {}

  /// The tile of a cell.
  Tile& at(int cell_x, int cell_y) {
    const int x = cell_x >> Tile::kShift;
    const int y = cell_y >> Tile::kShift;
    if (!tile_ || x != x_ || y != y_) {
      tile_ = &tiles_.write(x, y);
      x_ = x;
      y_ = y;
    }
    return *tile_;
  }

 private:
  TileGrid& tiles_;
  Tile* tile_ = nullptr;
  int x_ = 0;
  int y_ = 0;
};

}  // namespace

GridMap::GridMap(const MapOptions& options)
    : options_(options),
      hit_step_(step_of(options.hit_probability)),
      miss_step_(step_of(1.0 - options.miss_probability)),
      occupied_below_(integer_log_odds(1.0 - options.occupied_probability)) {}

void GridMap::hit(Tile& tile, int cell_x, int cell_y, const Eigen::Vector2d& point, std::uint16_t path) {
  const std::size_t i = cell_index(cell_x, cell_y);
  LogOdds::updateCell_fast_occupied(&tile.log_odds[i], hit_step_,
                                    static_cast<std::int8_t>(LogOdds::CELLTYPE_MIN + hit_step_));
  Endpoints& ends = tile.endpoints[i];
  const Eigen::Vector2d offset = (point - Eigen::Vector2d(cell_x + 0.5, cell_y + 0.5)) * Endpoints::kOffsetUnits;
  if (ends.hits < options_.max_hits) ++ends.hits;
  const auto blend = [&](std::int16_t old, double value) {
    return static_cast<std::int16_t>(std::lround(old + (std::clamp(value, -30000.0, 30000.0) - old) / ends.hits));
  };
  ends.offset_x = blend(ends.offset_x, offset.x());
  ends.offset_y = blend(ends.offset_y, offset.y());
  ends.last_path = seen_again(ends.hits == 1 ? path : ends.last_path, path);
  set_occupied(tile, cell_x, cell_y, tile.log_odds[i] < occupied_below_);
}

void GridMap::miss(Tile& tile, int cell_x, int cell_y) {
  const std::size_t i = cell_index(cell_x, cell_y);
  LogOdds::updateCell_fast_free(&tile.log_odds[i], miss_step_,
                                static_cast<std::int8_t>(LogOdds::CELLTYPE_MAX - miss_step_));
  if (tile.log_odds[i] >= occupied_below_) {
    set_occupied(tile, cell_x, cell_y, false);
    tile.endpoints[i] = {};
  }
}

void GridMap::insert(const ScanBeams& scan, const common::Pose2& pose, double path_length, InsertionScratch& scratch) {
  struct Ray {
    Eigen::Vector2d from, to;  // [cells]
    bool hit;
  };
  std::vector<Ray> rays;
  rays.reserve(scan.beams.size());
  Eigen::Array2d low = Eigen::Array2d::Constant(HUGE_VAL);
  Eigen::Array2d high = -low;
  for (const Beam& beam : scan.beams) {
    Ray ray{pose * beam.origin / options_.resolution, pose * beam.end / options_.resolution, beam.hit};
    const double length = (beam.end - beam.origin).norm();
    if (length > options_.mapping_range) {
      ray.to = ray.from + (ray.to - ray.from) * (options_.mapping_range / length);
      ray.hit = false;
    }
    const double farthest = std::max(ray.from.cwiseAbs().maxCoeff(), ray.to.cwiseAbs().maxCoeff());
    if (!(farthest * options_.resolution < kFarthest)) continue;
    low = low.min(ray.from.array()).min(ray.to.array());
    high = high.max(ray.from.array()).max(ray.to.array());
    rays.push_back(ray);
  }
  if (rays.empty()) return;
  const int min_x = cell_at(low.x()) - 1;
  const int min_y = cell_at(low.y()) - 1;
  const int width = cell_at(high.x()) + 2 - min_x;
  const int height = cell_at(high.y()) + 2 - min_y;
  if (!tiles_.include(min_x >> Tile::kShift, min_y >> Tile::kShift, (min_x + width) >> Tile::kShift,
                      (min_y + height) >> Tile::kShift)) {
    return;
  }
  const std::size_t area = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (scratch.marks.size() < area) scratch.marks.resize(area, 0);
  const std::uint32_t mark = ++scratch.generation;
  const auto mark_at = [&](int x, int y) -> std::uint32_t& {
    return scratch.marks[static_cast<std::size_t>(y - min_y) * static_cast<std::size_t>(width) +
                         static_cast<std::size_t>(x - min_x)];
  };

  const auto path = static_cast<std::uint16_t>(std::clamp(path_length / Endpoints::kPathUnit, 0.0, 65535.0));
  WrittenTile tile(tiles_);
  for (const Ray& ray : rays) {
    if (!ray.hit) continue;
    const int x = cell_at(ray.to.x());
    const int y = cell_at(ray.to.y());
    mark_at(x, y) = mark;
    hit(tile.at(x, y), x, y, ray.to, path);
  }
  for (const Ray& ray : rays) {
    const double length = (ray.to - ray.from).norm();
    if (length <= kRayMargin) continue;
    const Eigen::Vector2d stop =
        ray.hit ? Eigen::Vector2d(ray.to - (ray.to - ray.from) * (kRayMargin / length)) : ray.to;
    walk_cells(ray.from, stop, [&](int x, int y) {
      std::uint32_t& cell_mark = mark_at(x, y);
      if (cell_mark == mark) return;
      cell_mark = mark;
      miss(tile.at(x, y), x, y);
    });
  }
}

Surface GridMap::surface_at(const Eigen::Vector2d& point, int reach) const {
  const double res = options_.resolution;
  const Eigen::Vector2d in_cells = point / res;
  const Eigen::Vector2d from_center = Eigen::Vector2d::Constant(0.5) - in_cells;
  const double per_reach_squared = 1.0 / ((reach + 0.5) * (reach + 0.5));
  double sum = 0.0, sum_x = 0.0, sum_y = 0.0, sum_xx = 0.0, sum_xy = 0.0, sum_yy = 0.0, sum_path = 0.0;
  // Sums about the point itself, in cells: small numbers, no cancellation.
  for_each_occupied(tiles_, cell_at(in_cells.x()), cell_at(in_cells.y()), reach,
                    [&](const Tile& tile, int cell_x, int cell_y) {
                      const Endpoints& ends = tile.endpoints[cell_index(cell_x, cell_y)];
                      const double x = cell_x + from_center.x() + ends.offset_x * kOffsetUnit;
                      const double y = cell_y + from_center.y() + ends.offset_y * kOffsetUnit;
                      const double near = std::max(0.0, 1.0 - (x * x + y * y) * per_reach_squared);
                      const double weight = near * near * std::min<int>(ends.hits, kTrustedHits);
                      const double weight_x = weight * x;
                      const double weight_y = weight * y;
                      sum += weight;
                      sum_x += weight_x;
                      sum_y += weight_y;
                      sum_xx += weight_x * x;
                      sum_xy += weight_x * y;
                      sum_yy += weight_y * y;
                      sum_path += weight * ends.last_path;
                    });
  Surface surface;
  if (sum <= 0.0) return surface;
  const double per_sum = 1.0 / sum;
  const double mean_x = sum_x * per_sum;
  const double mean_y = sum_y * per_sum;
  surface.weight = sum;
  surface.mean = point + Eigen::Vector2d(mean_x, mean_y) * res;
  surface.xx = (sum_xx * per_sum - mean_x * mean_x) * res * res;
  surface.xy = (sum_xy * per_sum - mean_x * mean_y) * res * res;
  surface.yy = (sum_yy * per_sum - mean_y * mean_y) * res * res;
  surface.last_path = sum_path * per_sum * Endpoints::kPathUnit;
  return surface;
}

bool GridMap::occupied_near(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d in_cells = point / options_.resolution;
  bool found = false;
  for_each_occupied(tiles_, cell_at(in_cells.x()), cell_at(in_cells.y()), 1,
                    [&](const Tile&, int, int) { found = true; });
  return found;
}

bool GridMap::known_at(const Eigen::Vector2d& point) const {
  const int cell_x = cell_at(point.x() / options_.resolution);
  const int cell_y = cell_at(point.y() / options_.resolution);
  const Tile* tile = tiles_.find(cell_x >> Tile::kShift, cell_y >> Tile::kShift);
  return tile && tile->log_odds[cell_index(cell_x, cell_y)] != 0;
}

}  // namespace slamfuse::laser_slam
