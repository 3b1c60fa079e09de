// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>

#include "common/options.hpp"
#include "common/pose_estimate.hpp"
#include "common/time.hpp"
#include "fusion/disagreement_watch.hpp"
#include "fusion/odometry_drift.hpp"
#include "fusion/uncertain_pose.hpp"

namespace slamfuse::fusion {

struct CorrectedPoseOptions {
  OdometryDriftOptions drift;
  double gate = 16.27;
  double support_memory = 2.0;
  DisagreementOptions disagreement;

  void describe(common::OptionVisitor& visit) {
    visit.nested("drift", drift, "Errors of wheel odometry.");
    visit.real("gate", gate, {3.0, 1000.0}, "",
               "Squared Mahalanobis distance beyond which a pose is not used (16.27: one right pose in a thousand).");
    visit.real("support_memory", support_memory, {0.1, 60.0}, "s",
               "How long an accepted pose of one half speaks against a jump of the other.");
    visit.nested("disagreement", disagreement, "When poses beyond the gate are believed after all.");
  }
};

/// What became of a measured pose.
enum class MeasurementOutcome {
  kStarted,   ///< the first one: the filter begins there
  kFused,     ///< within the gate
  kGated,     ///< beyond the gate, not used
  kAdopted,   ///< beyond the gate for so long, and so consistently, that the filter went there
  kOverruled  ///< as kAdopted, but the other half confirms the filter's pose and speaks against: not used
};

/// A measured pose's fate and how far it was off.
struct MeasurementReport {
  MeasurementOutcome outcome = MeasurementOutcome::kGated;
  double squared_distance = 0.0;  ///< Mahalanobis, to the filter's pose before
  double jump = 0.0;              ///< [m] by which the filter moved when it adopted
};

/// Estimates T_map_base at the newest odometry pose, and with it T_map_odom. Odometry moves the pose and widens its
/// covariance. A measured pose enters by covariance intersection: laser and visual SLAM and this filter all used the
/// same odometry, and successive poses of one SLAM share the errors of its map, so no measurement is independent of
/// what is known already and counting them as such would make the filter overconfident within seconds.
///
/// One bad measurement is gated. Measurements of one source that stay beyond the gate but agree with each other are
/// adopted, unless the other source confirms the filter.
class CorrectedPoseFilter {
 public:
  explicit CorrectedPoseFilter(const CorrectedPoseOptions& options) : options_(options) {}

  bool started() const { return started_; }
  const UncertainPose& state() const { return state_; }  ///< T_map_base at the newest odometry pose
  const common::Pose2& T_odom_base() const { return T_odom_base_; }
  common::Pose2 T_map_odom() const { return state_.pose * T_odom_base_.inverse(); }

  /// Forgets everything; the next measurement starts anew.
  void restart();
  /// Odometry has come to `T_odom_base`; for `seconds_without_odometry` of the time since there was none.
  void move_to(const common::Pose2& T_odom_base, double seconds_without_odometry);
  /// Poses in the odometry frame are from now on given in another one, in which the old one is `T_new_old` (odometry
  /// has come, and its origin is somewhere): the pose in the map stays.
  void change_odometry_frame(const common::Pose2& T_new_old);
  /// A pose of base_link in the map frame measured at `stamp`, when odometry stood at `T_odom_base_then`, which may be
  /// before the newest: it is moved on by what odometry tells since. `seconds_without_odometry` is the part of that
  /// time without. The covariance must be positive definite.
  MeasurementReport measure(common::PoseSource source, common::Nanoseconds stamp, const UncertainPose& measured,
                            const common::Pose2& T_odom_base_then, double seconds_without_odometry);

 private:
  /// A pose of one source that was used last, kept at the odometry pose it was measured at.
  struct Support {
    common::Nanoseconds stamp = 0;
    UncertainPose pose;
    common::Pose2 T_odom_base;
  };

  bool other_speaks_against(common::PoseSource source, common::Nanoseconds stamp, const UncertainPose& candidate) const;

  CorrectedPoseOptions options_;
  bool started_ = false;
  UncertainPose state_;
  common::Pose2 T_odom_base_;
  std::map<common::PoseSource, Support> supports_;
  std::map<common::PoseSource, DisagreementWatch> watches_;
};

}  // namespace slamfuse::fusion
