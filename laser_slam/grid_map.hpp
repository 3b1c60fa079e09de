// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "laser_slam/map_options.hpp"
#include "laser_slam/scan_beams.hpp"
#include "laser_slam/tile_grid.hpp"

namespace slamfuse::laser_slam {

/// The mapped surface around a point: weighted moments of the mean endpoints of nearby occupied cells.
struct Surface {
  double weight = 0.0;                             ///< 0 where no occupied cell is near
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();  ///< [m], map frame
  double xx = 0.0, xy = 0.0, yy = 0.0;             ///< covariance about the mean [m^2]
  double last_path = 0.0;                          ///< robot's path length when it was last hit [m]
};

/// Memory that inserting scans reuses; one a thread.
struct InsertionScratch {
  std::vector<std::uint32_t> marks;
  std::uint32_t generation = 0;
};

/// The map of one particle: log-odds of occupancy (MRPT's int8 cells and update rule) and the running mean of the beam
/// endpoints of each cell, which knows surfaces better than the cell size. Copying is cheap, see TileGrid.
class GridMap {
 public:
  explicit GridMap(const MapOptions& options);

  static constexpr double kFarthest = 20000.0;  ///< [m]; beyond, tile numbers in saved maps end

  double resolution() const { return options_.resolution; }
  const TileGrid& tiles() const { return tiles_; }
  TileGrid& tiles() { return tiles_; }
  bool empty() const { return tiles_.width() == 0; }
  /// Cells with endpoints are matched while their integer log-odds are below this.
  std::int8_t occupied_below() const { return occupied_below_; }

  /// Draws a scan made at `pose`. A cell goes up for every beam that ends in it, and down once where beams only pass.
  /// `path_length` is how far the robot has travelled [m]. Left out are beams more than kFarthest from the origin, and
  /// scans that would stretch the map beyond TileGrid::kMaxTiles.
  void insert(const ScanBeams& scan, const common::Pose2& pose, double path_length, InsertionScratch& scratch);

  /// The surface near a point [m, map frame]: occupied cells up to `reach` cells away, each weighted by the biweight
  /// kernel (1 - d^2 / R^2)^2 with R = (reach + 1/2) cells of the distance from point to mean endpoint, and by its
  /// hits up to kTrustedHits.
  Surface surface_at(const Eigen::Vector2d& point, int reach) const;
  static constexpr int kTrustedHits = 8;

  /// Whether an occupied cell is at most one cell away from the point.
  bool occupied_near(const Eigen::Vector2d& point) const;
  /// Whether the cell at a point has ever been seen.
  bool known_at(const Eigen::Vector2d& point) const;

 private:
  /// A beam's endpoint [cells] in a cell of the tile.
  void hit(Tile& tile, int cell_x, int cell_y, const Eigen::Vector2d& point, std::uint16_t path);
  /// A beam passed through a cell of the tile.
  void miss(Tile& tile, int cell_x, int cell_y);

  MapOptions options_;
  std::int8_t hit_step_ = 0;  // MRPT's integer log-odds
  std::int8_t miss_step_ = 0;
  std::int8_t occupied_below_ = 0;  // matched below this value
  TileGrid tiles_;
};

}  // namespace slamfuse::laser_slam
