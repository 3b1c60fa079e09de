// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/source_monitor.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace slamfuse::fusion {
namespace {

constexpr double kUncertainScore = 0.6;
constexpr double kLongUncertainScore = 0.3;
constexpr double kHeldBackScore = 0.3;
constexpr double kSuspectBelow = 0.4;

}  // namespace

bool SourceMonitor::healthy(common::Nanoseconds now) const {
  return speaks(now) && own_state_ == common::TrackingState::kTracking && gated_in_a_row_ == 0 && !held_back_;
}

bool SourceMonitor::speaks(common::Nanoseconds now) const {
  return heard_ && common::to_seconds(now - stamp_) < options_.silent_after;
}

std::optional<double> SourceMonitor::lost_for(common::Nanoseconds now) const {
  if (!lost_since_ || !speaks(now)) return std::nullopt;
  return common::to_seconds(now - *lost_since_);
}

double SourceMonitor::overruled_for(common::Nanoseconds now) const {
  return overruled_since_ ? common::to_seconds(now - *overruled_since_) : 0.0;
}

void SourceMonitor::estimated(const common::PoseEstimate& estimate) {
  const bool steps_back = heard_ && estimate.stamp < stamp_;
  const bool was_silent = heard_ && common::to_seconds(estimate.stamp - stamp_) >= options_.silent_after;
  heard_ = true;
  if (steps_back) {
    lost_since_.reset();
    uncertain_since_.reset();
  }
  if (steps_back || was_silent || estimate.state == common::TrackingState::kLost) overruled_since_.reset();
  stamp_ = estimate.stamp;
  own_state_ = estimate.state;
  if (own_state_ == common::TrackingState::kLost) held_back_ = false;
  if (own_state_ != common::TrackingState::kUncertain) {
    uncertain_since_.reset();
  } else if (!uncertain_since_) {
    uncertain_since_ = stamp_;
  }
  if (own_state_ != common::TrackingState::kLost) {
    lost_since_.reset();
  } else if (!lost_since_) {
    lost_since_ = stamp_;
  }
}

void SourceMonitor::measured(const MeasurementReport& report, bool moves_otherwise) {
  moves_otherwise_ = moves_otherwise;
  held_back_ = report.outcome == MeasurementOutcome::kHeldBack;
  gated_in_a_row_ = report.fits() ? 0 : gated_in_a_row_ + 1;
  if (report.fits()) overruled_since_.reset();
  if (report.outcome == MeasurementOutcome::kOverruled && !overruled_since_) overruled_since_ = stamp_;
  squared_distance_ = report.squared_distance;
}

void SourceMonitor::shift(common::Nanoseconds by) {
  stamp_ += by;
  for (auto* since : {&overruled_since_, &lost_since_, &uncertain_since_}) {
    if (*since) **since += by;
  }
}

void SourceMonitor::forget_fit() {
  gated_in_a_row_ = 0;
  held_back_ = false;
  moves_otherwise_ = false;
  overruled_since_.reset();
}

StatusEntry SourceMonitor::status(common::Nanoseconds now) const {
  StatusEntry entry;
  entry.stamp = now;
  entry.source = source_;
  const double silence = common::to_seconds(now - stamp_);
  if (own_state_ == common::TrackingState::kLost) {
    entry.score = 0.0;
    entry.reasons.emplace_back("it says it is lost");
  } else if (own_state_ == common::TrackingState::kUncertain) {
    const bool long_since = common::to_seconds(stamp_ - *uncertain_since_) >= options_.uncertain_after;
    entry.score *= long_since ? kLongUncertainScore : kUncertainScore;
    entry.reasons.emplace_back("it says it is uncertain");
  }
  if (gated_in_a_row_ > 0) {
    entry.score /= 1.0 + gated_in_a_row_;
    if (moves_otherwise_) {
      entry.reasons.push_back(
          fmt::format("for {} poses it has not moved as the wheels and the other half have", gated_in_a_row_));
    } else {
      entry.reasons.push_back(fmt::format("its last {} poses contradict the fused pose (squared distance {:.1f})",
                                          gated_in_a_row_, squared_distance_));
      if (overruled()) entry.reasons.emplace_back("the other half is believed");
    }
  }
  if (held_back_) {
    entry.score *= kHeldBackScore;
    entry.reasons.emplace_back("it was told its pose and is not used for a while");
  }
  if (silence > options_.silent_after) {
    entry.score *= std::clamp((options_.lost_after - silence) / options_.lost_after, 0.0, 0.5);
    entry.reasons.push_back(fmt::format("silent for {:.1f} s", silence));
  }
  entry.state = entry.score <= 0.0            ? Verdict::kLost
                : entry.score < kSuspectBelow ? Verdict::kSuspect
                                              : Verdict::kTracking;
  return entry;
}

}  // namespace slamfuse::fusion
