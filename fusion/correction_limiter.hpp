// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"
#include "common/pose2.hpp"
#include "common/time.hpp"
#include "fusion/uncertain_pose.hpp"

namespace slamfuse::fusion {

struct CorrectionLimitOptions {
  double immediate_distance = 0.05;
  double immediate_turn = 0.05;
  double speed = 0.5;
  double turn_rate = 0.5;
  double settling_time = 2.0;

  void describe(common::OptionVisitor& visit) {
    visit.real("immediate_distance", immediate_distance, {0.0, 1.0}, "m", "Smaller corrections are made at once.");
    visit.real("immediate_turn", immediate_turn, {0.0, 1.0}, "rad", "Smaller turns are made at once.");
    visit.real("speed", speed, {0.01, 100.0}, "m/s", "The published correction moves the robot at most this fast.");
    visit.real("turn_rate", turn_rate, {0.01, 100.0}, "rad/s", "And turns it at most this fast.");
    visit.real("settling_time", settling_time, {0.05, 60.0}, "s",
               "A correction too large for that is made faster, so that it is complete after this time.");
  }
};

/// Makes the published pose follow the filter without jumps (REP 105 allows map -> odom to jump; controllers do not
/// like it). Small corrections pass at once, larger ones are spread over time; what is still missing is told in the
/// covariance.
class CorrectionLimiter {
 public:
  explicit CorrectionLimiter(const CorrectionLimitOptions& options) : options_(options) {}

  /// The pose to publish at `stamp`, where the filter stands at `target` and odometry at `T_odom_base`. The first call
  /// gives the target itself.
  UncertainPose follow(common::Nanoseconds stamp, const UncertainPose& target, const common::Pose2& T_odom_base);
  /// The next pose is the target again, without any transition (a new map frame).
  void restart() { started_ = false; }
  /// As CorrectedPoseFilter::change_odometry_frame: the published pose stays.
  void change_odometry_frame(const common::Pose2& T_new_old) { T_odom_base_ = T_new_old * T_odom_base_; }
  /// Distance [m] that the last published pose was still behind.
  double lag() const { return lag_; }

 private:
  CorrectionLimitOptions options_;
  bool started_ = false;
  common::Nanoseconds stamp_ = 0;
  common::Pose2 published_;
  common::Pose2 T_odom_base_;
  double lag_ = 0.0;
  bool settled_ = true;     ///< whether the last published pose was the target
  double speed_ = 0.0;      ///< of the correction under way [m/s]
  double turn_rate_ = 0.0;  ///< of the correction under way [rad/s]
};

}  // namespace slamfuse::fusion
