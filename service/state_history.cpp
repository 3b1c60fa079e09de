// SPDX-License-Identifier: BSD-3-Clause
#include "service/state_history.hpp"

#include <algorithm>
#include <utility>

#include "common/trajectory_coverage.hpp"

namespace slamfuse::service {

using common::kCoveredByPose;
using common::Nanoseconds;
using common::TrackingState;

namespace {

/// Adds a stretch that begins where the last one ends or later; one of the same state that follows at once lengthens
/// it.
void append(std::vector<StateStretch>& stretches, const StateStretch& next) {
  if (next.to <= next.from) return;
  if (!stretches.empty() && stretches.back().state == next.state && stretches.back().to == next.from) {
    stretches.back().to = next.to;
  } else {
    stretches.push_back(next);
  }
}

}  // namespace

void StateHistory::push(Nanoseconds stamp, TrackingState state) {
  if (!stretches_.empty()) {
    stamp = std::max(stamp, newest_);
    StateStretch& last = stretches_.back();
    last.to = std::min(last.to, stamp);
    if (last.to <= last.from) stretches_.pop_back();
  }
  newest_ = stamp;
  append(stretches_, {stamp, stamp + kCoveredByPose, state});
  if (stretches_.size() > most_) join_neighbours();
}

void StateHistory::join_neighbours() {
  std::vector<StateStretch> joined;
  for (std::size_t i = 0; i + 1 < stretches_.size(); i += 2) {
    const StateStretch& first = stretches_[i];
    const StateStretch& second = stretches_[i + 1];
    const bool hole = second.from > first.to;
    append(joined, {first.from, second.to, hole ? TrackingState::kLost : std::max(first.state, second.state)});
  }
  if (stretches_.size() % 2 == 1) append(joined, stretches_.back());
  stretches_ = std::move(joined);
}

std::vector<StateStretch> without_holes(const std::vector<StateStretch>& stretches, Nanoseconds from, Nanoseconds to) {
  std::vector<StateStretch> whole;
  if (stretches.empty()) return whole;
  Nanoseconds told_until = from;
  if (stretches.front().from <= from + kCoveredByPose) told_until = std::max(from, stretches.front().from);
  for (const StateStretch& stretch : stretches) {
    const Nanoseconds begin = std::clamp(stretch.from, told_until, std::max(told_until, to));
    append(whole, {told_until, begin, TrackingState::kLost});
    const Nanoseconds end = std::clamp(stretch.to, begin, std::max(begin, to));
    append(whole, {begin, end, stretch.state});
    told_until = end;
  }
  append(whole, {told_until, to, TrackingState::kLost});
  return whole;
}

}  // namespace slamfuse::service
