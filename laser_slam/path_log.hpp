// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/pose2.hpp"
#include "common/thinned_history.hpp"
#include "common/time.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::laser_slam {

/// Remembers each estimate relative to the filter update before it, so that the path can be told again once the
/// updates' poses are known better.
class PathLog {
 public:
  /// Keeps at most `most` estimates, thinned beyond.
  explicit PathLog(std::size_t most) : entries_(most) {}

  void clear();
  /// A filter update has happened. `arrival`: where the online path came to it, relative to the update before; empty
  /// for the first one and where the pose was set from outside.
  void begin_segment(std::optional<common::Pose2> arrival);
  /// An estimate, relative to the last update's pose of the then best particle.
  void add(common::Nanoseconds stamp, const common::Pose2& since_update);

  /// The estimates placed on the updates' poses as they are believed now (one each begin_segment). Inside a segment
  /// the difference between the online path's arrival and the next update's pose is spread evenly over the estimates.
  common::Trajectory2 compose(const std::vector<common::Pose2>& updates) const;

 private:
  struct Entry {
    common::Nanoseconds stamp;
    common::Pose2 since_update;
    std::size_t segment;
    std::size_t place;  // in the segment
  };
  struct Segment {
    std::optional<common::Pose2> arrival;  // at this segment's start, from the one before
    std::size_t entries = 0;               // kept or not
  };
  common::ThinnedHistory<Entry> entries_;
  std::vector<Segment> segments_;
};

}  // namespace slamfuse::laser_slam
