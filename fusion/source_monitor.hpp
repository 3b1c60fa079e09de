// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/options.hpp"
#include "common/pose_estimate.hpp"
#include "fusion/corrected_pose_filter.hpp"
#include "fusion/status.hpp"

namespace slamfuse::fusion {

struct SourceMonitorOptions {
  double silent_after = 1.0;
  double lost_after = 2.0;
  double uncertain_after = 1.0;

  void describe(common::OptionVisitor& visit) {
    visit.real("silent_after", silent_after, {0.05, 60.0}, "s", "A half that has been silent this long is suspect.");
    visit.real("lost_after", lost_after, {0.1, 600.0}, "s", "A half that has been silent this long is lost.");
    visit.real("uncertain_after", uncertain_after, {0.0, 600.0}, "s",
               "A half that has called itself uncertain this long is suspect.");
  }
};

/// Judges one half from what it says of itself, whether it still speaks, and how its poses fit the fused one.
class SourceMonitor {
 public:
  SourceMonitor(common::PoseSource source, const SourceMonitorOptions& options) : source_(source), options_(options) {}

  bool heard() const { return heard_; }
  common::Nanoseconds last_stamp() const { return stamp_; }
  /// Whether it keeps telling another place than the fused pose although the other half confirms that one.
  bool overruled() const { return overruled_since_.has_value(); }
  /// For how long [s] it has been overruled.
  double overruled_for(common::Nanoseconds now) const;
  /// Its own word at its last estimate.
  common::TrackingState own_state() const { return own_state_; }
  /// For how long [s] it has been calling itself lost; nothing if it does not, or is silent.
  std::optional<double> lost_for(common::Nanoseconds now) const;
  /// Whether it still speaks.
  bool speaks(common::Nanoseconds now) const;
  /// Whether it still speaks, calls itself tracking, and its last pose was used.
  bool healthy(common::Nanoseconds now) const;

  /// It made an estimate; what the filter did with it follows in `measured`, if it was usable at all.
  void estimated(const common::PoseEstimate& estimate);
  /// `moves_otherwise`: it was not used because it does not move as the wheels and the other half do.
  void measured(const MeasurementReport& report, bool moves_otherwise = false);

  /// All input paused for so long, which does not count, or the clock was set by so much.
  void shift(common::Nanoseconds by);
  /// Its map or its frame is new, or it was told its pose: how its poses fitted before does not count.
  void forget_fit();

  /// The verdict at `now`. Score: 1, times 0.6 if it calls itself uncertain, 0.3 if it has for long, times 1 / (1 +
  /// poses gated in a row), 0.3 while it is held back, times a factor that falls to 0 as it stays silent; 0 if it calls
  /// itself lost. SUSPECT below 0.4, LOST at 0.
  StatusEntry status(common::Nanoseconds now) const;

 private:
  common::PoseSource source_;
  SourceMonitorOptions options_;
  bool heard_ = false;
  common::Nanoseconds stamp_ = 0;
  common::TrackingState own_state_ = common::TrackingState::kTracking;
  bool held_back_ = false;  // its last pose fitted and was not to be used
  int gated_in_a_row_ = 0;
  bool moves_otherwise_ = false;
  std::optional<common::Nanoseconds> overruled_since_;
  std::optional<common::Nanoseconds> lost_since_;
  std::optional<common::Nanoseconds> uncertain_since_;
  double squared_distance_ = 0.0;
};

}  // namespace slamfuse::fusion
