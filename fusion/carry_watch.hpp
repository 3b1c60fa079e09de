// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <utility>

#include "common/pose_estimate.hpp"
#include "common/time.hpp"
#include "fusion/source_monitor.hpp"
#include "fusion/status.hpp"
#include "fusion/supervision_options.hpp"

namespace slamfuse::fusion {

/// By half: kLaser and kVisual, both always there.
using SourceMonitors = std::map<common::PoseSource, SourceMonitor>;

/// Asks whether the robot was carried, i.e. moved by other than its wheels, from what the halves say: one stops
/// tracking, is lost, finds itself elsewhere, or both fall silent. Odometry cannot tell, and halves notice late, one
/// after the other.
class CarryWatch {
 public:
  /// `silent_after` [s] is how long both halves must have been silent.
  CarryWatch(const SupervisionOptions& options, double silent_after) : options_(options), silent_after_(silent_after) {}

  /// A half speaks; `before` is its monitor as it was until then. `stamp` is the estimate's by the laser's clock.
  void estimated(const common::PoseEstimate& estimate, common::Nanoseconds stamp, const SourceMonitor& before,
                 bool pose_known);
  /// A pose of a half was brought into the map frame, where it is `off` the fused pose (T_fused_measured), and used or
  /// not.
  void measured(const common::PoseEstimate& estimate, const common::Pose2& off, bool used);

  /// Whether what was known of the pose is void: one half at least is lost and every one that speaks is lost or
  /// elsewhere for `both_lost_after`, or sees nothing for `help_after`; or one was lost and has found itself elsewhere,
  /// and no other is healthy at the old place.
  bool carried(const SourceMonitors& monitors, common::Nanoseconds now) const;
  /// The pose was given up because of a carry; what the halves said before does not count any more.
  void give_up(const SourceMonitors& monitors, common::Nanoseconds now);
  /// Since it was given up no pose has been used.
  bool gave_up() const { return gave_up_; }
  /// Whether a pose may start the fused pose anew: after a carry not one of a half that only guesses (unless nobody
  /// does better for `contradiction_time`), and none of one that has not noticed while the one that has still speaks.
  bool may_start(const common::PoseEstimate& estimate, const SourceMonitors& monitors, common::Nanoseconds now) const;
  /// The fused pose has begun anew, with this pose.
  void found(const common::PoseEstimate& estimate);

  /// Adds what speaks against the fused pose.
  void judge(const SourceMonitors& monitors, common::Nanoseconds now, StatusEntry& entry) const;

  /// All input paused for so long, which does not count, or the clock was set by so much.
  void shift(common::Nanoseconds by);
  /// The map of one half is new.
  void forget(common::PoseSource source);
  /// The map frame is new.
  void restart();

 private:
  /// What one half has said since it last confirmed the fused pose.
  struct Doubt {
    std::optional<common::Nanoseconds> since;            ///< it stopped tracking
    bool lost = false;                                   ///< it has called itself lost
    std::optional<common::Nanoseconds> elsewhere_since;  ///< it tracks somewhere else
    std::optional<common::Nanoseconds> blind_since;      ///< it sees nothing of its map
  };

  /// Whether a half whose pictures show features stops tracking because they had become few before: as before a blank
  /// wall. After a carry there are many, and then none.
  bool ran_out_of_features(const common::PoseEstimate& estimate) const;
  /// For how long [s] every half that speaks has been lost or elsewhere, one at least being lost; nothing else. One
  /// that sees nothing may only have its eyes covered: its time counts from later on.
  std::optional<double> disowned_for(const SourceMonitors& monitors, common::Nanoseconds now) const;
  /// The half that was lost and has found itself elsewhere while no other is healthy at the old place.
  std::optional<common::PoseSource> found_elsewhere(const SourceMonitors& monitors, common::Nanoseconds now) const;

  SupervisionOptions options_;
  double silent_after_;
  std::map<common::PoseSource, Doubt> doubts_;
  std::map<common::PoseSource, std::pair<int, int>> last_seen_;  ///< features in the last two pictures that had any
  std::optional<common::Nanoseconds> heard_at_;                  ///< stamp of the newest estimate of either half
  std::optional<common::Nanoseconds> silent_until_;              ///< when the last silence of both halves ended
  bool gave_up_ = false;
  common::Nanoseconds gave_up_at_ = 0;
  std::optional<common::PoseSource> found_by_;  ///< the half whose word counts after a carry, having noticed it
};

/// The other one of laser and visual.
common::PoseSource other_half(common::PoseSource source);

}  // namespace slamfuse::fusion
