// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/source_monitor.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace slamfuse::fusion {
namespace {

constexpr double kUncertainScore = 0.6;
constexpr double kLongUncertainScore = 0.3;
constexpr double kSuspectBelow = 0.4;

}  // namespace

bool SourceMonitor::healthy(common::Nanoseconds now) const {
  return speaks(now) && own_state_ == common::TrackingState::kTracking && gated_in_a_row_ == 0;
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
  heard_ = true;
  if (estimate.stamp < stamp_) {  // the clock steps back
    lost_since_.reset();
    uncertain_since_.reset();
  }
  stamp_ = estimate.stamp;
  own_state_ = estimate.state;
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

void SourceMonitor::measured(const MeasurementReport& report) {
  const bool used = report.outcome != MeasurementOutcome::kGated && report.outcome != MeasurementOutcome::kOverruled;
  gated_in_a_row_ = used ? 0 : gated_in_a_row_ + 1;
  if (used) overruled_since_.reset();
  if (report.outcome == MeasurementOutcome::kOverruled && !overruled_since_) overruled_since_ = stamp_;
  squared_distance_ = report.squared_distance;
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
    entry.reasons.push_back(fmt::format("its last {} poses contradict the fused pose (squared distance {:.1f})",
                                        gated_in_a_row_, squared_distance_));
    if (overruled()) entry.reasons.emplace_back("the other half confirms the fused pose");
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
