// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "common/options.hpp"
#include "common/time.hpp"
#include "fusion/odometry_drift.hpp"
#include "fusion/uncertain_pose.hpp"

namespace slamfuse::fusion {

struct MotionCheckOptions {
  double window = 1.0;
  double gate = 16.27;

  void describe(common::OptionVisitor& visit) {
    visit.real("window", window, {0.2, 10.0}, "s", "Over this time a half's motion is compared with the odometry's.");
    visit.real("gate", gate, {3.0, 1000.0}, "",
               "Squared Mahalanobis distance beyond which the two are not the same motion.");
  }
};

/// Compares how a half says the robot moved with what wheel odometry says, over the last moment. A half that is fed
/// something else than the robot sees (a frozen sensor, another place) may drift away so slowly that none of its poses
/// is beyond a gate; but it does not move as the wheels do, while the other half does. Alone it proves nothing: wheels
/// slip, and a closed loop moves a right half at once.
class MotionCheck {
 public:
  MotionCheck(const MotionCheckOptions& options, const OdometryDriftOptions& drift)
      : options_(options), drift_(drift) {}

  /// The next pose of the half in its own frame, of `scale` metres per unit, with the covariance of what is new in
  /// every pose, measured when odometry stood at `T_odom_base`.
  void add(common::Nanoseconds stamp, const UncertainPose& pose, double scale, const common::Pose2& T_odom_base);
  /// Whether it moved as odometry did up to its last pose; nothing while there is no window yet, or none of late.
  std::optional<bool> plausible(common::Nanoseconds now) const;
  /// Whether it did, and could have told it from standing still: a robot that hardly moves, or a half that hardly knows
  /// where it is, is no witness.
  bool confirms(common::Nanoseconds now) const { return plausible(now) == true && is_telling_; }
  /// The poses to come do not continue those before: another map, or a command.
  void forget();

 private:
  struct Step {
    common::Nanoseconds stamp = 0;
    UncertainPose pose;
    common::Pose2 T_odom_base;
  };

  MotionCheckOptions options_;
  OdometryDriftOptions drift_;
  std::deque<Step> steps_;  ///< of the last window, oldest first, and one before it
  std::optional<bool> plausible_;
  bool is_telling_ = false;
};

}  // namespace slamfuse::fusion
