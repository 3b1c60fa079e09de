// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "laser_slam/grid_map.hpp"
#include "laser_slam/keyframe.hpp"
#include "laser_slam/pose_graph.hpp"
#include "laser_slam/scan_matcher.hpp"

namespace slamfuse::laser_slam {

/// A map of a few scans made one after the other: short enough to be rigid, whatever the path around it does.
struct Submap {
  GridMap map;               ///< in the frame of base_link at its first keyframe
  std::vector<int> members;  ///< indices of the keyframes drawn into it, rising
};

/// The path of a run in pieces that each are right, without any loop.
struct LocalMapping {
  std::vector<Submap> submaps;
  std::vector<PoseConstraint> motions;      ///< from keyframe to keyframe
  std::vector<PoseConstraint> memberships;  ///< from submap (its index) to a keyframe in it
};

/// Matches each keyframe in the submap of the scans before it, and draws it there and into the next submap, which began
/// half a submap later (Hess et al. 2016, Real-Time Loop Closure in 2D LIDAR SLAM, section IV). Since only the last
/// metres are matched against, a closed loop shows up nowhere: its error stays for the pose graph to spread.
/// `submap_scans` keyframes make a submap. `poses` are the keyframes' poses as the filter ended with them; they connect
/// what follows after the pose was set from outside, weakly.
LocalMapping map_locally(const std::vector<Keyframe>& keyframes, const std::vector<common::Pose2>& poses,
                         const ScanMatcher& matcher, const MapOptions& map_options, int submap_scans);

}  // namespace slamfuse::laser_slam
