// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/pose2.hpp"
#include "laser_slam/keyframe.hpp"
#include "laser_slam/map_options.hpp"
#include "laser_slam/refinement_options.hpp"
#include "laser_slam/scan_matcher.hpp"

namespace slamfuse::laser_slam {

/// Tells a path again in hindsight. The particle filter closes a loop by choosing the path that happened to fit; what
/// is left of the drift stays in one place, where the loop closed. Here it is spread over the loop: rigid submaps
/// (map_locally), loops between scans and the submaps of other times, found from where the filter put them, and a pose
/// graph over both (optimise_poses), repeated since better poses find more loops.
///
/// `poses` are those of the keyframes, T_map_base, by the best particle; the first one stays. Scans and submaps less
/// than `least_path_apart` [m] of path from each other make no loop. The loops are searched by `threads` threads, whose
/// number changes nothing but the time.
std::vector<common::Pose2> refine_path(const std::vector<Keyframe>& keyframes, const std::vector<common::Pose2>& poses,
                                       const ScanMatcher& matcher, const MapOptions& map_options,
                                       const RefinementOptions& options, double least_path_apart, int threads);

/// The map of the keyframes' scans at these poses, one each.
GridMap draw_map(const std::vector<Keyframe>& keyframes, const std::vector<common::Pose2>& poses,
                 const MapOptions& map_options);

}  // namespace slamfuse::laser_slam
