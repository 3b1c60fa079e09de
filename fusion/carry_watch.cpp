// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/carry_watch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace slamfuse::fusion {

using common::Nanoseconds;
using common::PoseEstimate;
using common::PoseSource;
using common::TrackingState;

namespace {

/// So many features of the map where they should be are no chance.
constexpr int kMany = 10;

bool sees(const PoseEstimate& estimate) { return estimate.health.inliers && *estimate.health.inliers >= kMany; }

}  // namespace

PoseSource other_half(PoseSource source) {
  return source == PoseSource::kLaser ? PoseSource::kVisual : PoseSource::kLaser;
}

void CarryWatch::estimated(const PoseEstimate& estimate, Nanoseconds stamp, const SourceMonitor& before,
                           bool pose_known) {
  const bool silent = heard_at_ && common::to_seconds(estimate.stamp - *heard_at_) >= silent_after_;
  if (silent && pose_known) silent_until_ = estimate.stamp;
  heard_at_ = std::max(heard_at_.value_or(estimate.stamp), estimate.stamp);  // poses come late, too

  const auto last = before.heard() ? before.own_state() : TrackingState::kLost;
  const bool stops = last == TrackingState::kTracking && estimate.state != TrackingState::kTracking;
  const bool is_lost_now = last != TrackingState::kLost && estimate.state == TrackingState::kLost;
  Doubt& doubt = doubts_[estimate.source];
  if (estimate.health.inliers && *estimate.health.inliers > 0) {
    auto& [one, two] = last_seen_[estimate.source];
    one = std::exchange(two, *estimate.health.inliers);
  }
  if (((stops && !ran_out_of_features(estimate)) || is_lost_now) && !doubt.since) doubt.since = stamp;
  if (estimate.state != TrackingState::kTracking) found_by_.reset();
  if (estimate.state == TrackingState::kLost) doubt.lost = true;
  if (estimate.state != TrackingState::kTracking) doubt.elsewhere_since.reset();
  if (estimate.state == TrackingState::kTracking && !doubt.lost) doubt.since.reset();
  const bool is_blind = estimate.state != TrackingState::kTracking && estimate.health.inliers == 0;
  if (!is_blind) {
    doubt.blind_since.reset();
  } else if (!doubt.blind_since) {
    doubt.blind_since = estimate.stamp;
  }
}

bool CarryWatch::ran_out_of_features(const PoseEstimate& estimate) const {
  if (!estimate.health.inliers) return false;
  const auto seen = last_seen_.find(estimate.source);
  return seen == last_seen_.end() || std::max(seen->second.first, seen->second.second) < kMany;
}

void CarryWatch::measured(const PoseEstimate& estimate, const common::Pose2& off, bool used) {
  if (estimate.state != TrackingState::kTracking) return;
  const bool bent = estimate.source == PoseSource::kVisual && options_.visual_scale_drifts;
  const bool far =
      off.translation().norm() > options_.lost_position_sigma || std::abs(off.theta) > options_.lost_heading_sigma;
  Doubt& own = doubts_[estimate.source];
  if (used || bent || !far) {
    own.elsewhere_since.reset();
  } else if (!own.elsewhere_since) {
    own.elsewhere_since = estimate.stamp;
  }
  if (!used) return;
  own = {};
  // After a carry the other half may take a moment longer to notice, and vouches for nothing until then: a scan may fit
  // a place that looks alike, pictures with many features of the map where they are expected do not. (Clocks that step
  // back do not keep it waiting.)
  Doubt& other = doubts_[other_half(estimate.source)];
  const bool elsewhere = other.lost && other.elsewhere_since;
  const double patience = sees(estimate) ? options_.both_lost_after
                          : elsewhere    ? options_.contradiction_time
                                         : options_.help_after;
  const auto begun = elsewhere ? other.elsewhere_since : other.since;
  if (!begun || std::abs(common::to_seconds(estimate.stamp - *begun)) >= patience) other = {};
}

std::optional<double> CarryWatch::disowned_for(const SourceMonitors& monitors, Nanoseconds now) const {
  std::optional<double> shortest;
  bool is_one_lost = false;
  for (const auto& [source, monitor] : monitors) {
    if (!monitor.speaks(now)) continue;
    auto since = monitor.lost_for(now);
    is_one_lost = is_one_lost || since.has_value();
    const auto doubt = doubts_.find(source);
    if (!since && doubt != doubts_.end()) {
      const auto& [stopped, lost, elsewhere, blind] = doubt->second;
      if (elsewhere) {
        since = common::to_seconds(now - *elsewhere);
      } else if (blind) {
        since = common::to_seconds(now - *blind) - (options_.help_after - options_.both_lost_after);
      }
    }
    if (!since || *since < 0.0) return std::nullopt;
    shortest = std::min(*since, shortest.value_or(*since));
  }
  return is_one_lost ? shortest : std::nullopt;
}

std::optional<PoseSource> CarryWatch::found_elsewhere(const SourceMonitors& monitors, Nanoseconds now) const {
  for (const auto& [source, doubt] : doubts_) {
    if (doubt.lost && doubt.elsewhere_since && !monitors.at(other_half(source)).healthy(now)) return source;
  }
  return std::nullopt;
}

bool CarryWatch::carried(const SourceMonitors& monitors, Nanoseconds now) const {
  const auto disowned = disowned_for(monitors, now);
  return (disowned && *disowned >= options_.both_lost_after) || found_elsewhere(monitors, now);
}

void CarryWatch::give_up(const SourceMonitors& monitors, Nanoseconds now) {
  found_by_ = found_elsewhere(monitors, now);
  doubts_.clear();
  gave_up_ = true;
  gave_up_at_ = now;
}

void CarryWatch::found(const PoseEstimate& estimate) {
  if (!gave_up_) return;
  gave_up_ = false;
  if (estimate.state != TrackingState::kTracking) doubts_[estimate.source].since = estimate.stamp;
}

void CarryWatch::shift(Nanoseconds by) {
  const auto move = [by](std::optional<Nanoseconds>& stamp) {
    if (stamp) *stamp += by;
  };
  move(heard_at_);
  move(silent_until_);
  gave_up_at_ += by;
  for (auto& [source, doubt] : doubts_) {
    move(doubt.since);
    move(doubt.elsewhere_since);
    move(doubt.blind_since);
  }
}

bool CarryWatch::may_start(const PoseEstimate& estimate, const SourceMonitors& monitors, Nanoseconds now) const {
  if (!gave_up_) return true;
  if (estimate.state != TrackingState::kTracking) {
    const bool is_better_off = std::any_of(monitors.begin(), monitors.end(), [now](const auto& half) {
      return half.second.speaks(now) && half.second.own_state() == TrackingState::kTracking;
    });
    return !is_better_off && common::to_seconds(now - gave_up_at_) >= options_.contradiction_time;
  }
  return !found_by_ || estimate.source == *found_by_ || !monitors.at(*found_by_).speaks(now);
}

void CarryWatch::judge(const SourceMonitors& monitors, Nanoseconds now, StatusEntry& entry) const {
  if (disowned_for(monitors, now)) {
    entry.state = Verdict::kSuspect;
    entry.reasons.emplace_back("every half that speaks says it is lost or somewhere else");
  } else if (silent_until_ && now >= *silent_until_ && common::to_seconds(now - *silent_until_) < options_.help_after) {
    entry.state = Verdict::kSuspect;
    entry.reasons.emplace_back("both halves were silent until a moment ago: the robot may have been carried");
  }
  for (const auto& [source, doubt] : doubts_) {
    if (!doubt.since || !monitors.at(source).speaks(now)) continue;
    if (doubt.lost && doubt.elsewhere_since) {
      entry.state = Verdict::kLost;
      entry.score = 0.0;
      entry.reasons.push_back(
          fmt::format("the {} half was lost and has found itself somewhere else", common::to_string(source)));
    } else if (entry.state == Verdict::kTracking) {
      entry.state = Verdict::kSuspect;
      entry.reasons.push_back(
          fmt::format("the {} half does not track any more, and the other has not confirmed the pose since",
                      common::to_string(source)));
    }
  }
}

void CarryWatch::forget(PoseSource source) {
  doubts_.erase(source);
  found_by_.reset();
}

void CarryWatch::restart() {
  doubts_.clear();
  found_by_.reset();
  silent_until_.reset();
  gave_up_ = false;
}

}  // namespace slamfuse::fusion
