// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/command.hpp"
#include "common/error.hpp"
#include "common/pose_estimate.hpp"
#include "common/sensor_message.hpp"
#include "common/thinned_history.hpp"
#include "common/trajectory.hpp"
#include "fusion/alignment.hpp"
#include "fusion/fusion_options.hpp"
#include "fusion/status.hpp"

namespace slamfuse::fusion {

/// The pose the robot should believe, split as REP 105 wants it.
struct CorrectedPose {
  common::PoseEstimate estimate;  ///< source kFused: T_map_base with covariance, never of state LOST
  common::Pose2 T_map_odom;       ///< the correction on top of wheel odometry; T_map_base where there is none
};

/// Something the fusion asks of one half.
struct ModuleCommand {
  common::PoseSource target = common::PoseSource::kLaser;  ///< kLaser or kVisual
  common::Command command;                                 ///< poses in the target's own map frame
};

/// What one input led to.
struct FusionOutput {
  std::optional<CorrectedPose> pose;    ///< none while LOST
  std::vector<ModuleCommand> commands;  ///< for the pipeline to hand on
  std::vector<common::Event> events;    ///< module "fusion"
  std::vector<StatusEntry> status;      ///< rows of status.csv: when a state changed, else once a second
  std::optional<std::string> rejected;  ///< why the input was dropped, if it was; nothing changed then
};

/// What is known at the end of a run.
struct FusionResult {
  Alignment alignment;              ///< of the final paths
  common::Trajectory2 fused_final;  ///< the path as known at the end, at the stamps of the corrected poses
  std::vector<common::Event> events;
};

/// Fuses wheel odometry, laser poses and visual poses into one corrected pose in the laser's map frame (in the visual
/// map frame as long as there is no laser, in which case `map_frame()` says so). Trajectories only, so any two SLAM
/// systems can feed it. Deterministic in the sequence of calls; not for several threads at a time.
class Fusion {
 public:
  /// Of what the final path and alignments are made from at most `most_kept` poses of a kind are kept, thinned beyond
  /// (see common::ThinnedHistory). An option out of its range, or an angle step that does not divide 90 degrees, is an
  /// Error (kInvalidInput).
  static common::Result<std::unique_ptr<Fusion>> create(const FusionOptions& options,
                                                        std::size_t most_kept = common::kKeepAll);
  ~Fusion();

  /// The next odometry message, in arrival order.
  FusionOutput process(const common::WheelOdometry& odometry);
  /// The next pose of the laser or the visual half, in arrival order; it may be older than the newest odometry.
  FusionOutput process(const common::PoseEstimate& estimate);
  /// Takes an alignment of earlier: both halves are in saved maps. It holds until one that fits better is found, and at
  /// the end when the final paths are refused.
  void assume(const Alignment& alignment);
  /// Aligns with all that was collected so far, as the service `align_now` asks.
  FusionOutput align_now();
  /// Final alignment on the halves' final paths (either may be empty) and the path as known at the end.
  FusionResult finish(const common::Trajectory2& laser_final, const common::Trajectory2& visual_final);

  /// The alignment in use: the last accepted one, else the last refused one; nothing before the first attempt.
  const std::optional<Alignment>& alignment() const;
  /// Whose map frame the corrected pose is in: kLaser or kVisual.
  common::PoseSource map_frame() const;

 private:
  Fusion(const FusionOptions& options, std::size_t most_kept);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace slamfuse::fusion
