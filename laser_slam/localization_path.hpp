// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "common/pose2.hpp"
#include "common/thinned_history.hpp"
#include "common/time.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::laser_slam {

/// The path of a localisation, told again when a pose that was searched for is found.
class LocalizationPath {
 public:
  /// Keeps at most `most` of what the scans told, thinned beyond.
  explicit LocalizationPath(std::size_t most) : steps_(most) {}

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
  std::size_t now() const { return steps_.count(); }
  /// It turned out LOST: the poses since the last scan that agreed are not known.
  void lost();
  /// The last pose was found right, and its hypothesis has been held since `moment`: places those not known between,
  /// where it was the best one as it was matched then, else by the predicted motion.
  void found_since(std::size_t moment);
  void clear() { steps_.clear(); }
  /// The known poses, in the order they were made.
  common::Trajectory2 trajectory() const;

 private:
  struct Step : Entry {
    common::Pose2 increment;  // from the kept one before
    std::size_t number = 0;   // of all
  };
  /// Where one goes, the next one's increment reaches over it.
  struct Chain {
    void operator()(Step& next, const Step& gone) const;
  };

  common::ThinnedHistory<Step, Chain> steps_;
};

}  // namespace slamfuse::laser_slam
