// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/trajectory_pairing.hpp"

#include <algorithm>

namespace slamfuse::fusion {
namespace {

common::Trajectory2 usable(const common::Trajectory2& trajectory) {
  const auto is_finite = [](const common::StampedPose2& pose) { return pose.pose.is_finite(); };
  if (std::all_of(trajectory.begin(), trajectory.end(), is_finite)) return common::sorted_by_stamp(trajectory);
  common::Trajectory2 finite;
  finite.reserve(trajectory.size());
  std::copy_if(trajectory.begin(), trajectory.end(), std::back_inserter(finite), is_finite);
  return common::sorted_by_stamp(finite);
}

/// Poses of `trajectory` (sorted) within the time `other` (sorted, not empty) covers.
std::size_t poses_within(const common::Trajectory2& trajectory, const common::Trajectory2& other) {
  return static_cast<std::size_t>(
      std::count_if(trajectory.begin(), trajectory.end(), [&](const common::StampedPose2& pose) {
        return pose.stamp >= other.front().stamp && pose.stamp <= other.back().stamp;
      }));
}

}  // namespace

std::vector<PosePair> pair_trajectories(const common::Trajectory2& laser, const common::Trajectory2& visual,
                                        const PairingOptions& options) {
  const common::Trajectory2 sorted_laser = usable(laser);
  const common::Trajectory2 sorted_visual = usable(visual);
  std::vector<PosePair> pairs;
  if (sorted_laser.empty() || sorted_visual.empty()) return pairs;

  const common::Nanoseconds max_gap = common::from_seconds(options.max_gap);
  const bool at_laser_stamps = poses_within(sorted_laser, sorted_visual) < poses_within(sorted_visual, sorted_laser);
  const common::Trajectory2& sampled = at_laser_stamps ? sorted_laser : sorted_visual;
  const common::Trajectory2& interpolated = at_laser_stamps ? sorted_visual : sorted_laser;
  pairs.reserve(sampled.size());
  common::PoseCursor others(interpolated, max_gap);
  for (const common::StampedPose2& pose : sampled) {
    const auto other = others.at(pose.stamp);
    if (!other) continue;
    pairs.push_back(at_laser_stamps ? PosePair{pose.stamp, pose.pose, *other}
                                    : PosePair{pose.stamp, *other, pose.pose});
  }
  return pairs;
}

std::vector<PosePair> without_standstill(const std::vector<PosePair>& pairs, const PairingOptions& options) {
  std::vector<PosePair> moving;
  moving.reserve(pairs.size());
  for (const PosePair& pair : pairs) {
    const bool moved =
        moving.empty() || (pair.laser.translation() - moving.back().laser.translation()).norm() >= options.min_step;
    if (moved) moving.push_back(pair);
  }
  return moving;
}

}  // namespace slamfuse::fusion
