// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/annotated_image.hpp"
#include "common/calibration.hpp"
#include "common/error.hpp"
#include "common/keyframe.hpp"
#include "common/landmark.hpp"
#include "common/occupancy_grid.hpp"
#include "common/trajectory.hpp"
#include "common/trajectory_evaluation.hpp"
#include "fusion/fusion.hpp"
#include "service/module_counters.hpp"
#include "service/run_recorder.hpp"

namespace slamfuse::service {

/// A trajectory of a run under the name it has in the output: "odometry", "laser", ..., "fused_final".
struct NamedTrajectory {
  std::string name;
  common::Trajectory2 trajectory;
};

/// The accuracy of a trajectory against the ground truth.
struct NamedAccuracy {
  std::string name;
  common::TrajectoryAccuracy accuracy;
};

/// All that a run gave: what every output file is made from.
struct RunSummary {
  std::uint64_t seed = 0;
  std::string recording;
  bool incomplete = false;   ///< interrupted
  double duration_s = 0.0;   ///< recording time that was processed
  double wall_s = 0.0;       ///< of the run without the writing of its results
  double peak_rss_mb = 0.0;  ///< largest resident memory of the process so far [10^6 bytes]
  common::Nanoseconds first_stamp = 0;
  common::Nanoseconds last_stamp = 0;
  RunLog log;
  std::map<common::PoseSource, ModuleCounters> counters;  ///< the fusion as kFused
  std::map<common::PoseSource, double> coverage;          ///< by module, 0..1
  std::vector<NamedTrajectory> trajectories;              ///< in the order of DESIGN section 5
  common::Trajectory2 truth;                              ///< of the processed stretch; empty when there is none
  std::vector<NamedAccuracy> accuracy;                    ///< empty without truth
  std::optional<fusion::Alignment> alignment;             ///< when both modules ran
  std::optional<common::OccupancyGrid> grid;
  std::string laser_state;
  std::vector<common::Landmark> landmarks;                   ///< of the visual map, in its frame
  std::vector<common::Keyframe> keyframes;                   ///< there, too
  std::map<std::string, common::CameraCalibration> cameras;  ///< of the visual module
  std::vector<common::AnnotatedImage> sample_images;         ///< what it saw
};

}  // namespace slamfuse::service
