// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/occupancy_grid.hpp"

namespace slamfuse::laser_slam {

/// For every cell of a finished map the distance from its centre to that of the nearest occupied cell, capped, and
/// whether the cell is known: one byte a cell. (Thrun, Burgard, Fox: Probabilistic Robotics, section 6.4; exact
/// distance transform in O(cells) by Felzenszwalb and Huttenlocher, Theory of Computing 2012.)
class LikelihoodField {
 public:
  /// A cell's byte: distance in 1/127 of the cap, the highest bit set where the map knows nothing.
  using Code = std::uint8_t;
  static constexpr Code kUnknown = 0x80;
  static constexpr Code kFarthest = 0x7f;

  /// Cells of 65 percent and more are occupied, of 25 percent and less free, others unknown: a map in use is the same
  /// as saved and read back. `farthest` [m] is the cap, > 0.
  LikelihoodField(const common::OccupancyGrid& grid, double farthest);

  double resolution() const { return resolution_; }
  int width() const { return width_; }
  int height() const { return height_; }
  const Eigen::Vector2d& origin() const { return origin_; }
  double farthest() const { return farthest_; }

  /// The byte of a cell; outside the map unknown and far.
  Code code(int column, int row) const {
    if (column < 0 || row < 0 || column >= width_ || row >= height_) return kUnknown | kFarthest;
    return codes_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column)];
  }
  Code code_at(const Eigen::Vector2d& point) const {
    return code(static_cast<int>(std::floor((point.x() - origin_.x()) / resolution_)),
                static_cast<int>(std::floor((point.y() - origin_.y()) / resolution_)));
  }
  /// The distance a byte stands for [m].
  double distance_of(Code code) const { return (code & kFarthest) * farthest_ / kFarthest; }
  /// Distance from the cell of a point [m, map frame] to the nearest occupied cell [m].
  double distance_at(const Eigen::Vector2d& point) const { return distance_of(code_at(point)); }
  static bool is_occupied(Code code) { return code == 0; }
  static bool is_free(Code code) { return code != 0 && (code & kUnknown) == 0; }

  /// Whether a segment [m, map frame] meets an occupied cell and then comes `beyond` [m] away from all of them (sampled
  /// at half cells). One that grazes a wall and ends there does not.
  bool passes_wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double beyond) const;

 private:
  double resolution_;
  int width_;
  int height_;
  Eigen::Vector2d origin_;
  double farthest_;
  std::vector<Code> codes_;
};

}  // namespace slamfuse::laser_slam
