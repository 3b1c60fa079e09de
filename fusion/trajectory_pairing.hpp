// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/options.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::fusion {

struct PairingOptions {
  double max_gap = 0.5;
  double min_step = 0.02;

  void describe(common::OptionVisitor& visit) {
    visit.real("max_gap", max_gap, {0.0, 10.0}, "s",
               "A pose is interpolated only between neighbours of the other trajectory at most this far away in time.");
    visit.real("min_step", min_step, {0.0, 10.0}, "m",
               "A pair nearer than this (by the laser) to the last one that counts does not count: a robot that stands "
               "must not outvote its own drive.");
  }
};

/// Where both halves say base_link was at the same time, each in its own map frame.
struct PosePair {
  common::Nanoseconds stamp = 0;
  common::Pose2 laser;   ///< T_laser_map_base
  common::Pose2 visual;  ///< T_visual_map_base, in the visual map's unit
};

/// Pairs two trajectories by time (seed 004, III.A: "coordinates ... corresponding to the same timestamps"): at the
/// stamps of the trajectory with fewer poses in the time both cover, the other is interpolated, so no pair is made up
/// from two others. Neither needs to be sorted. Poses that are not finite are left out. Pairs come in the order of
/// time; none if the two have no time in common.
std::vector<PosePair> pair_trajectories(const common::Trajectory2& laser, const common::Trajectory2& visual,
                                        const PairingOptions& options);

/// The pairs at least `options.min_step` of laser motion apart from the one kept before; the first is kept.
std::vector<PosePair> without_standstill(const std::vector<PosePair>& pairs, const PairingOptions& options);

}  // namespace slamfuse::fusion
