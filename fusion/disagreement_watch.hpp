// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"
#include "common/time.hpp"
#include "fusion/odometry_drift.hpp"
#include "fusion/uncertain_pose.hpp"

namespace slamfuse::fusion {

struct DisagreementOptions {
  int poses = 3;
  double seconds = 0.4;

  void describe(common::OptionVisitor& visit) {
    visit.integer("poses", poses, {2, 1000}, "", "So many gated poses in a row must agree with each other.");
    visit.real("seconds", seconds, {0.0, 60.0}, "s", "And they must span at least this time.");
  }
};

/// Watches the poses of one source that were gated: do they contradict each other (noise), or do they tell the same
/// other story again and again (the source or the filter is somewhere else)?
class DisagreementWatch {
 public:
  explicit DisagreementWatch(const DisagreementOptions& options) : options_(options) {}

  /// A pose was used: whatever was told before does not count any more.
  void clear() { count_ = 0; }
  /// As CorrectedPoseFilter::change_odometry_frame.
  void change_odometry_frame(const common::Pose2& T_new_old) { last_T_odom_base_ = T_new_old * last_T_odom_base_; }

  /// Takes the next gated pose and tells whether the story has lasted long enough. Two poses tell the same story when
  /// the odometry between them explains their difference within `gate`.
  bool persists(common::Nanoseconds stamp, const UncertainPose& gated, const common::Pose2& T_odom_base, double gate,
                const OdometryDriftOptions& drift);

 private:
  DisagreementOptions options_;
  int count_ = 0;
  common::Nanoseconds first_stamp_ = 0;
  UncertainPose last_;
  common::Pose2 last_T_odom_base_;
};

}  // namespace slamfuse::fusion
