// SPDX-License-Identifier: BSD-3-Clause
#include "service/stamp_guard.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace slamfuse::service {
namespace {

/// A stamp farther ahead of all others is garbled, or a robot's clock was set.
constexpr common::Nanoseconds kFarAhead = 10 * common::kNanosecondsPerSecond;
/// So long a sensor has to insist on a new time.
constexpr std::chrono::seconds kPatience{1};

}  // namespace

StampGuard::Verdict StampGuard::judge(const std::string& sensor, common::Nanoseconds stamp, Arrival arrival) {
  Track& track = tracks_[sensor];
  const bool back = track.last && stamp <= *track.last;
  const bool ahead = newest_ && stamp > *newest_ + kFarAhead;
  if (!back && !ahead) {
    track = {stamp, std::nullopt};
    newest_ = std::max(stamp, newest_.value_or(stamp));
    return {};
  }
  const bool repeats = back && stamp == *track.last;
  const double by = common::to_seconds(stamp - (back ? *track.last : *newest_));
  if (!repeats && insists(track, stamp, arrival)) {
    if (back) return {Kind::kSteppedBack, fmt::format("the clock of {} stepped back by {:.3f} s", sensor, -by)};
    track = {stamp, std::nullopt};
    newest_ = stamp;
    return {Kind::kClockJumped, fmt::format("the clock of {} jumped ahead by {:.3f} s", sensor, by)};
  }
  if (repeats) return {Kind::kRefused, fmt::format("stamp {} repeats (allowed: rising stamps)", stamp)};
  if (back)
    return {Kind::kRefused, fmt::format("stamp {} steps back by {:.3f} s (allowed: rising stamps)", stamp, -by)};
  return {Kind::kRefused, fmt::format("stamp {} is {:.3f} s ahead of all others (allowed: {:.0f} s)", stamp, by,
                                      common::to_seconds(kFarAhead))};
}

void StampGuard::reset() {
  tracks_.clear();
  newest_.reset();
}

bool StampGuard::insists(Track& track, common::Nanoseconds stamp, Arrival arrival) {
  if (!track.refused || stamp <= track.refused->last) {
    track.refused = Refused{arrival, stamp};
    return false;
  }
  track.refused->last = stamp;
  return arrival - track.refused->since >= kPatience;
}

}  // namespace slamfuse::service
