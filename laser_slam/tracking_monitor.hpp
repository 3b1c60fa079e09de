// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "common/pose_estimate.hpp"
#include "common/time.hpp"

namespace slamfuse::laser_slam {

/// From what agreement a TrackingState follows.
struct TrackingThresholds {
  double uncertain = 0.45;
  double lost = 0.25;
  double lost_time = 2.0;  ///< [s]
};

/// Judges from each scan's agreement with the map whether the pose can be relied on.
class TrackingMonitor {
 public:
  explicit TrackingMonitor(const TrackingThresholds& thresholds) : thresholds_(thresholds) {}

  /// Takes the next scan's agreement; empty where too little of it fell into mapped space to tell (the state stays).
  void add(common::Nanoseconds stamp, std::optional<double> agreement);
  /// Trusts the pose again, after it was set from outside.
  void reset();

  common::TrackingState state() const { return state_; }
  /// Whether the scan fits well enough to be drawn into the map.
  bool may_map() const { return !low_since_; }
  /// Whether the last scan began or ended being LOST.
  bool just_lost() const { return just_lost_; }
  bool just_found() const { return just_found_; }

 private:
  TrackingThresholds thresholds_;
  common::TrackingState state_ = common::TrackingState::kTracking;
  std::optional<common::Nanoseconds> low_since_;
  bool just_lost_ = false;
  bool just_found_ = false;
};

}  // namespace slamfuse::laser_slam
