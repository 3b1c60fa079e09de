// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <map>
#include <optional>

#include <Eigen/Core>

#include "common/options.hpp"
#include "common/pose_estimate.hpp"
#include "common/time.hpp"
#include "fusion/disagreement_watch.hpp"
#include "fusion/odometry_drift.hpp"
#include "fusion/uncertain_pose.hpp"

namespace slamfuse::fusion {

/// How the errors of a half's map change along the drive.
struct MapErrorOptions {
  double length = 3.0;
  double random_share = 0.2;

  void describe(common::OptionVisitor& visit) {
    visit.real("length", length, {0.1, 1000.0}, "m",
               "After this distance the error of a half's map has changed by most of what it can.");
    visit.real("random_share", random_share, {0.001, 1.0}, "",
               "The part of a pose's variance that is new with every pose; the rest is the error of the map there.");
  }
};

struct CorrectedPoseOptions {
  OdometryDriftOptions drift;
  MapErrorOptions map_error;
  double shared_position_sigma = 0.02;
  double shared_heading_sigma = 0.01;
  double gate = 16.27;
  double support_memory = 2.0;
  DisagreementOptions disagreement;

  void describe(common::OptionVisitor& visit) {
    visit.nested("drift", drift, "Errors of wheel odometry.");
    visit.nested("map_error", map_error, "Errors of the halves' maps.");
    visit.real(
        "shared_position_sigma", shared_position_sigma, {0.0, 1.0}, "m",
        "What both halves may be off by together (they follow the same wheels): in the stated covariance, and in "
        "the gate once for each of the two poses compared, without weight between them.");
    visit.real("shared_heading_sigma", shared_heading_sigma, {0.0, 1.0}, "rad", "The same of the heading.");
    visit.real("gate", gate, {3.0, 1000.0}, "",
               "Squared Mahalanobis distance beyond which a pose is not used (16.27: one right pose in a thousand).");
    visit.real("support_memory", support_memory, {0.1, 60.0}, "s",
               "How long an accepted pose of one half speaks against a jump of the other.");
    visit.nested("disagreement", disagreement, "When poses beyond the gate are believed after all.");
  }
};

/// What became of a measured pose.
enum class MeasurementOutcome {
  kStarted,    ///< the first one: the filter begins there
  kFused,      ///< within the gate
  kGated,      ///< beyond the gate, not used
  kAdopted,    ///< beyond the gate for so long, and so consistently, that the filter went there
  kOverruled,  ///< as kAdopted, but not used: it was to be held back, or the other half confirms the filter's pose
  kHeldBack    ///< within the gate, but not to be used
};

/// A measured pose's fate and how far it was off.
struct MeasurementReport {
  MeasurementOutcome outcome = MeasurementOutcome::kGated;
  double squared_distance = 0.0;  ///< Mahalanobis, to the pose the filter expected
  double jump = 0.0;              ///< [m] by which the filter moved when it adopted

  /// Whether the filter took it.
  bool used() const { return fits() && outcome != MeasurementOutcome::kHeldBack; }
  /// Whether it was within the gate or the filter went there.
  bool fits() const { return outcome != MeasurementOutcome::kGated && outcome != MeasurementOutcome::kOverruled; }
};

/// Estimates T_map_base at the newest odometry pose together with what each half's map is off
/// by *here*. A pose z of half h is
///
///     z = x + m_h + v,   var m_h = (1 - q) C,  var v = q C,
///
/// all in (x, y, theta), with C the covariance it comes with and q `random_share`. Most of what SLAM is off by is the
/// error of its map at the place, m_h: poses on the next metre have it too, so their mean is no better than one. It is
/// taken as a Gauss-Markov process over the distance driven,
///
///     m(s + d) = e^(-d / l) m(s) + w,   var w = (1 - e^(-2 d / l)) (1 - q) C.
///
/// Odometry moves x and widens it. State (x, m_laser, m_visual) and its 9x9 covariance follow by the usual Kalman
/// update. While both halves speak x lies between them, as their covariances say, and what remains of their difference
/// is in m_laser and m_visual; when one falls silent the other carries on without a step, and its m goes back to 0 over
/// the next metres.
///
/// One bad measurement is gated. Measurements of one source that stay beyond the gate but agree with each other are
/// adopted, unless the other source confirms the filter.
class CorrectedPoseFilter {
 public:
  explicit CorrectedPoseFilter(const CorrectedPoseOptions& options);

  bool started() const { return started_; }
  /// T_map_base at the newest odometry pose.
  UncertainPose state() const { return {pose_, covariance_.topLeftCorner<3, 3>() + shared_}; }
  const common::Pose2& T_odom_base() const { return T_odom_base_; }
  /// The pose that a half would measure here: x + m_h.
  UncertainPose expected(common::PoseSource source) const;

  /// Forgets everything; the next measurement starts anew.
  void restart();
  /// Odometry has come to `T_odom_base`; for `seconds_without_odometry` of the time since there was none.
  void move_to(const common::Pose2& T_odom_base, double seconds_without_odometry);
  /// Poses in the odometry frame are from now on given in another one, in which the old one is `T_new_old` (odometry
  /// has come, and its origin is somewhere): the pose in the map stays.
  void change_odometry_frame(const common::Pose2& T_new_old);
  /// Whether it has used a pose of this half, so that m_h is estimated.
  bool knows(common::PoseSource source) const { return error_of(source).known; }
  /// The poses of a half are from now on given in another way, e.g. with another alignment, that moves them here by
  /// `step` in (x, y, theta): the corrected pose stays. A step beyond the gate leaves nothing known of m_h.
  void shift(common::PoseSource source, const Eigen::Vector3d& step);
  /// The map of a half is new: what was known of its error is void.
  void forget(common::PoseSource source);
  /// A pose of base_link in the map frame measured at `stamp`, when odometry stood at `T_odom_base_then`, which may be
  /// before the newest: it is moved on by what odometry tells since. `seconds_without_odometry` is the part of that
  /// time without. The covariance must be positive definite. A pose to be `held_back` is judged as any other but does
  /// not move the filter, however long it tells the same.
  MeasurementReport measure(common::PoseSource source, common::Nanoseconds stamp, const UncertainPose& measured,
                            const common::Pose2& T_odom_base_then, double seconds_without_odometry,
                            bool held_back = false);

 private:
  using Covariance = Eigen::Matrix<double, 9, 9>;

  /// m of one half.
  struct MapError {
    bool known = false;                                   ///< it has told a pose since the start
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();       ///< m
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();     ///< its variance where nothing is known, (1 - q) C
    Eigen::Matrix3d scaled_to = Eigen::Matrix3d::Zero();  ///< the spread that mean and covariance are parts of
  };

  /// A pose of one source that was used last, kept at the odometry pose it was measured at.
  struct Support {
    common::Nanoseconds stamp = 0;
    UncertainPose pose;
    common::Pose2 T_odom_base;
  };

  MapError& error_of(common::PoseSource source) { return errors_[index_of(source)]; }
  const MapError& error_of(common::PoseSource source) const { return errors_[index_of(source)]; }
  static std::size_t index_of(common::PoseSource source) { return source == common::PoseSource::kLaser ? 0 : 1; }
  /// Begins at a pose of `source`, of which `random` is new with every pose.
  void start_at(common::PoseSource source, const UncertainPose& measured, const Eigen::Matrix3d& random);
  void update(common::PoseSource source, const Eigen::Vector3d& innovation, const Eigen::Matrix3d& random);
  /// Nothing is known of m any more but its spread.
  void reset_error(common::PoseSource source);
  /// The half's own covariance has changed, and with it the spread of m. Where it is much larger or smaller what was
  /// estimated of m is so many parts of it as before.
  void change_spread(common::PoseSource source, const Eigen::Matrix3d& spread);
  bool other_speaks_against(common::PoseSource source, common::Nanoseconds stamp, const UncertainPose& candidate) const;

  CorrectedPoseOptions options_;
  Eigen::Matrix3d shared_;  ///< variances of what both halves are off by together
  bool started_ = false;
  common::Pose2 pose_;
  std::array<MapError, 2> errors_;              ///< laser, visual
  Covariance covariance_ = Covariance::Zero();  ///< of (x, m_laser, m_visual)
  common::Pose2 T_odom_base_;
  std::map<common::PoseSource, Support> supports_;
  std::map<common::PoseSource, DisagreementWatch> watches_;
};

}  // namespace slamfuse::fusion
