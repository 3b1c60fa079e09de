// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/odometry_clock.hpp"

#include <algorithm>
#include <utility>

namespace slamfuse::fusion {
namespace {

using common::kNanosecondsPerSecond;
using common::Nanoseconds;

/// A pause is this many usual gaps long, and at least a quarter of a second. In one of more than four seconds the robot
/// may have been carried.
constexpr Nanoseconds kUsualGaps = 4;
constexpr Nanoseconds kShortestPause = kNanosecondsPerSecond / 4;
constexpr Nanoseconds kLongestPause = 4 * kNanosecondsPerSecond;
/// The usual gap follows the last ones by this part of the difference.
constexpr Nanoseconds kFollowing = 10;

}  // namespace

void OdometryClock::heard(Nanoseconds stamp) {
  paused_ = false;
  spoke_in_gap_ = spoke_in_gap_ || (last_ && stamp > *last_);
}

Nanoseconds OdometryClock::next(Nanoseconds stamp) {
  const auto last = std::exchange(last_, stamp);
  const bool spoke_in_gap = std::exchange(spoke_in_gap_, false);
  if (!last) return 0;
  const Nanoseconds gap = stamp - *last;
  if (gap < 0) return gap;
  if (!usual_gap_) {
    usual_gap_ = gap;
    return 0;
  }
  const bool is_long = gap > kUsualGaps * *usual_gap_ && gap >= kShortestPause && gap <= kLongestPause;
  *usual_gap_ += (std::min(gap, kUsualGaps * *usual_gap_) - *usual_gap_) / kFollowing;
  if (!is_long || spoke_in_gap || paused_) return 0;
  paused_ = true;
  return gap;
}

}  // namespace slamfuse::fusion
