// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "common/thinned_history.hpp"
#include "common/trajectory.hpp"
#include "visual_slam/ekf.hpp"
#include "visual_slam/observation_log.hpp"

namespace slamfuse::visual_slam {

/// Remembers every estimate and tells, at any time, the path as it is believed then.
///
/// Keyframe poses are part of the filter's state, so each later measurement (above all a loop closure) corrects them
/// through the cross-covariances: that is the smoothing. An estimate between two keyframes hangs on both by the wheel
/// odometry in between, and the two answers are blended by time. An estimate made while lost is part of the path only
/// between two keyframes that hang together: else nobody knows whether the robot was carried before or after it.
class PathRecorder {
 public:
  /// Keeps at most `most` estimates, thinned beyond; those that keyframes or pictures hang on stay.
  explicit PathRecorder(std::size_t most = common::kKeepAll) : entries_(most) {}

  /// `filter` has made an estimate; `odometry` is T_odom_base at its stamp. `pictures` are those remembered by now.
  void add(common::Nanoseconds stamp, const common::Pose3& odometry, bool lost, const Ekf& filter,
           const ObservationLog& pictures);
  /// The pose is about to be replaced from outside: nothing is blended across this point.
  void start_segment() { ++segment_; }
  /// The estimates since `since` turned out to be somewhere else: they hang on what comes after them.
  void restart_since(common::Nanoseconds since);
  /// The map is about to be forgotten: the path so far stays as `filter` believes it now.
  void freeze(const Ekf& filter);
  /// The estimates from `stamp` on are made again.
  void forget_since(common::Nanoseconds stamp);
  /// In the order of the stamps. Planar filters keep it in the plane z = 0.
  common::Trajectory3 path(const Ekf& filter) const;

 private:
  struct Entry {
    common::Nanoseconds stamp;
    int segment;
    common::Pose3 odometry;
    std::optional<common::Pose3> estimate;  // none: frozen while lost
    bool lost;
    bool misplaced;  // no keyframe there counts
    bool frozen;     // the estimate is final; so are those before
  };
  /// A pose known well: its place in the path and what the filter says of it now.
  struct Support {
    std::size_t entry;
    common::Pose3 corrected;
  };

  /// From an entry on, in their order.
  std::vector<Support> supports_from(std::size_t first, const Ekf& filter) const;
  /// The poses from an entry on, as far as they are known.
  std::vector<std::optional<common::Pose3>> poses_from(std::size_t first, const Ekf& filter) const;

  /// The number of entries whose estimate is final.
  std::size_t frozen() const;

  common::ThinnedHistory<Entry> entries_;
  int segment_ = 0;
};

}  // namespace slamfuse::visual_slam
