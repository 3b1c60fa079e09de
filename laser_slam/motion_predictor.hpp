// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "common/odometry_buffer.hpp"
#include "common/pose2.hpp"
#include "common/time.hpp"
#include "laser_slam/motion_model_options.hpp"

namespace slamfuse::laser_slam {

/// The motion expected between two scans.
struct MotionPrediction {
  common::Pose2 increment;       ///< T_base(last scan)_base(this scan)
  double seconds = 0.0;          ///< between the scans; not positive where stamps step back
  double at_most_seconds = 0.0;  ///< what the motion may have taken: longer than that after a stall of the messages
  bool from_odometry = false;
  bool suspicious = false;  ///< odometry too fast to be true, see is_jump(): other motions must be considered
};

/// Predicts the motion from scan to scan: by wheel odometry where there is some, else by the last matched speed.
class MotionPredictor {
 public:
  explicit MotionPredictor(const MotionModelOptions& options) : options_(options) {}

  void add(const common::WheelOdometry& odometry) { odometry_.add(odometry); }
  /// Begins at a scan: the next prediction counts from here, at rest.
  void start(common::Nanoseconds stamp);
  /// Forgets the speed: the robot was put somewhere else.
  void forget_speed() { twist_.setZero(); }
  /// The motion since the last scan given to start() or finish().
  MotionPrediction predict(common::Nanoseconds stamp) const;
  /// Ends the step to a scan with the motion it was found to have been.
  void finish(common::Nanoseconds stamp, const MotionPrediction& prediction, const common::Pose2& matched);
  /// Begins a scan that takes `duration`: the body twist [m/s, m/s, rad/s] while its sweep passes, zero for duration 0.
  /// By the odometry, or the last matched speed where that is missing or jumps.
  Eigen::Vector3d begin_sweep(common::Nanoseconds stamp, common::Nanoseconds duration);
  /// The motion from the last scan to the one begun at the last matched speed; none over a gap too long for a speed to
  /// last.
  common::Pose2 at_last_speed(double seconds) const;

 private:
  Eigen::Vector3d sweep_twist(common::Nanoseconds stamp, common::Nanoseconds duration) const;

  MotionModelOptions options_;
  common::OdometryBuffer odometry_;
  common::Nanoseconds last_stamp_ = 0;
  std::optional<common::Pose2> last_odometry_;       // as it was asked for at the last scan
  Eigen::Vector3d twist_ = Eigen::Vector3d::Zero();  // last matched speed
  // How long nothing had come before the last scan [s]; 0 for a usual interval. What comes first after a stall often
  // carries the odometry of its beginning, and the next one makes up for all of it (aces).
  double stalled_ = 0.0;
  // A match fixes base_link in the middle of the sweep; where it was at the first beam follows from the twist the sweep
  // was undone with. So speeds are taken from middle to middle: from first beam to first beam an error of the speed
  // would come back in the next one, and swings without end where sweeps fill the time between scans.
  common::Pose2 last_half_;   // T_base(first beam)_base(middle) of the last scan
  common::Pose2 begun_half_;  // the same of the scan begun
};

}  // namespace slamfuse::laser_slam
