// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "common/pose_estimate.hpp"
#include "common/time.hpp"
#include "laser_slam/localization_options.hpp"

namespace slamfuse::laser_slam {

/// What a scan says about the pose.
struct LocalizationEvidence {
  common::Nanoseconds stamp = 0;
  int hypothesis = 0;      ///< id of the best one
  double agreement = 0.0;  ///< share of the beams that the map explains at the pose
  double mass = 0.0;       ///< probability of the best hypothesis
  double spread = 0.0;     ///< standard deviation of its particles [m]
  double driven = 0.0;     ///< since the last scan [m], turning counted as well
};

/// Judges whether the pose in a finished map can be relied on: from the scans' agreement with the map and from the
/// hypotheses that stand beside it.
///
/// A pose that was searched for is LOST until one hypothesis explains `confirm_scans` over `confirm_distance` of
/// driving. A known pose becomes UNCERTAIN with a doubtful scan, another probable hypothesis or a wide spread, LOST
/// when the scans disagree for `lost_time` or another hypothesis takes over.
class LocalizationMonitor {
 public:
  explicit LocalizationMonitor(const LocalizationMonitorOptions& options) : options_(options) {}

  /// The pose has to be searched for.
  void lose();
  /// The pose was told from outside: to be verified by the first scans.
  void trust();
  void add(const LocalizationEvidence& evidence);

  common::TrackingState state() const { return state_; }
  /// Whether the last scan began or ended being LOST.
  bool just_lost() const { return just_lost_; }
  bool just_found() const { return just_found_; }

 private:
  void search(const LocalizationEvidence& evidence, bool good);
  void watch(const LocalizationEvidence& evidence, bool good);

  LocalizationMonitorOptions options_;
  common::TrackingState state_ = common::TrackingState::kLost;
  std::optional<int> hypothesis_;                 // that the state is about
  double held_ = 0.0;                             // [m] it explained the scans while searching ...
  int held_scans_ = 0;                            // ... and how many
  std::optional<common::Nanoseconds> low_since_;  // agreement below lost_agreement
  bool just_lost_ = false;
  bool just_found_ = false;
};

}  // namespace slamfuse::laser_slam
