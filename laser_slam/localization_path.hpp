// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "common/pose2.hpp"
#include "common/time.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::laser_slam {

/// The path of a localisation, told again when a pose that was searched for is found.
class LocalizationPath {
 public:
  /// What one scan told.
  struct Entry {
    common::Nanoseconds stamp = 0;
    common::Pose2 pose;   ///< of the best hypothesis
    int hypothesis = -1;  ///< its id
    bool good = false;    ///< the scan agrees with the map there
    bool known = false;   ///< not LOST
  };

  /// `increment` is the predicted motion since the last one.
  void add(const Entry& entry, const common::Pose2& increment);
  /// The number of scans so far: a moment that found_since() understands.
  std::size_t now() const { return entries_.size(); }
  /// It turned out LOST: the poses since the last scan that agreed are not known.
  void lost();
  /// The last pose was found right, and its hypothesis has been held since `moment`: places those not known between,
  /// where it was the best one as it was matched then, else by the predicted motion.
  void found_since(std::size_t moment);
  void clear();
  /// The known poses, in the order they were made.
  common::Trajectory2 trajectory() const;

 private:
  std::vector<Entry> entries_;
  std::vector<common::Pose2> increments_;  // to each entry from the one before
};

}  // namespace slamfuse::laser_slam
