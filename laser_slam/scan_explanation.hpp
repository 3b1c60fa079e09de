// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "laser_slam/likelihood_field.hpp"

namespace slamfuse::laser_slam {

/// How the map explains a scan at a pose, beam by beam.
struct ScanExplanation {
  int explained = 0;     ///< ends at a wall of the map, and sees it
  int in_the_way = 0;    ///< ends in the map's free space: something stands there that the map does not know
  int contradicted = 0;  ///< went through a wall of the map
  int unmapped = 0;      ///< ends where the map knows nothing, without going through a wall: tells nothing

  /// Share of the beams explained, 0..1, with those in the way counting `short_weight` and those unmapped nothing. 0
  /// when fewer than a fifth of the beams tell anything.
  double agreement(double short_weight) const;
};

/// Looks along every beam from the laser at `mount` (base_link) to the ends `points` (base_link). A beam that ends
/// within `tolerance` [m] of a wall is explained unless it went through another wall before.
ScanExplanation explain_scan(const LikelihoodField& field, const Eigen::Vector2d& mount,
                             const std::vector<Eigen::Vector2d>& points, const common::Pose2& pose, double tolerance);

/// Whether a beam from `laser` to `end` [m, map frame] went through a wall: it met one and came farther than
/// kBeyondWall away from it. A beam that grazes a wall meets its cells long before its end, and stays near them.
bool passes_wall(const LikelihoodField& field, const Eigen::Vector2d& laser, const Eigen::Vector2d& end);
inline constexpr double kBeyondWall = 0.2;  ///< [m]

}  // namespace slamfuse::laser_slam
