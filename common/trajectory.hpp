// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/pose2.hpp"
#include "common/pose3.hpp"
#include "common/time.hpp"

namespace slamfuse::common {

/// A planar pose of base_link at a time.
struct StampedPose2 {
  Nanoseconds stamp = 0;
  Pose2 pose;
};

/// A pose in space at a time.
struct StampedPose3 {
  Nanoseconds stamp = 0;
  Pose3 pose;
};

/// Poses in the order they were made. Stamps usually increase; a CARMEN log may step back (DESIGN section 2), so
/// functions that search by time say so.
using Trajectory2 = std::vector<StampedPose2>;
using Trajectory3 = std::vector<StampedPose3>;

/// Length [m] of the polyline through the positions.
double path_length(const Trajectory2& trajectory);

/// A copy sorted by stamp; of several poses with one stamp the last one made stays.
Trajectory2 sorted_by_stamp(const Trajectory2& trajectory);

/// The planar parts of a trajectory in a z-up frame.
Trajectory2 to_planar(const Trajectory3& trajectory);
Trajectory3 to_spatial(const Trajectory2& trajectory);

/// The pose at `stamp`, interpolated between its neighbours (position linear, heading by the shortest turn).
/// `trajectory` must be sorted by stamp. Returns nothing outside it, or when either neighbour is farther than `max_gap`
/// from `stamp` (an exact hit always counts).
std::optional<Pose2> pose_at(const Trajectory2& trajectory, Nanoseconds stamp, Nanoseconds max_gap);

/// pose_at for many stamps, each near the one before: searches from where it found the last one.
class PoseCursor {
 public:
  /// `trajectory` must be sorted by stamp and outlive this.
  PoseCursor(const Trajectory2& trajectory, Nanoseconds max_gap) : trajectory_(trajectory), max_gap_(max_gap) {}

  /// As pose_at, whatever was asked before.
  std::optional<Pose2> at(Nanoseconds stamp);

 private:
  const Trajectory2& trajectory_;
  Nanoseconds max_gap_;
  std::ptrdiff_t place_ = 0;  ///< of the first pose not before the stamp last asked for
};

}  // namespace slamfuse::common
