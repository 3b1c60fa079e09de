// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/annotated_image.hpp"
#include "common/occupancy_grid.hpp"
#include "common/pose_estimate.hpp"
#include "common/time.hpp"
#include "common/trajectory.hpp"
#include "service/state_history.hpp"
#include "service/structure_picture.hpp"

namespace slamfuse::service {

/// How far an estimate was from the truth at one moment.
struct ReportError {
  common::Nanoseconds stamp = 0;
  double position = 0.0;  ///< [m]
  double heading = 0.0;   ///< signed [rad]
};

/// How long one input took.
struct ReportUpdate {
  common::Nanoseconds stamp = 0;
  double milliseconds = 0.0;
};

/// What the report tells of one source of poses.
struct ReportSource {
  common::PoseSource source = common::PoseSource::kLaser;
  /// The path to draw, in the frame of the grid: the visual path brought over by the alignment, the odometry put on the
  /// first laser pose. Empty: not drawn.
  common::Trajectory2 path;
  /// Estimates with their health, in order: all, or of a long session some. Empty for the odometry.
  std::vector<common::PoseEstimate> estimates;
  /// When it was in which state, told by all estimates. Empty for the odometry.
  std::vector<StateStretch> states;
  std::vector<ReportError> errors;    ///< empty without ground truth
  std::vector<ReportUpdate> updates;  ///< computing time of each input
};

/// One row of the accuracy table, as in metrics.json.
struct ReportAccuracy {
  std::string name;                   ///< "odometry", "laser", "visual", "fused", "laser_final", ...
  std::string align;                  ///< "se2", "sim2", "none", "as"
  double ate_rmse = 0.0;              ///< [m]
  double ate_max = 0.0;               ///< [m]
  double heading_rmse = 0.0;          ///< [rad]
  std::optional<double> rpe_percent;  ///< none when the path is too short for it
  double coverage = 0.0;              ///< 0..1
};

/// One row of the module table, as in metrics.json.
struct ReportModule {
  std::string name;  ///< "laser", "visual", "fusion"
  std::size_t inputs = 0;
  std::size_t poses = 0;
  std::size_t dropped = 0;
  std::size_t rejected = 0;
  double coverage = 0.0;  ///< 0..1
  double update_median_ms = 0.0;
  double update_p95_ms = 0.0;
  double update_p99_ms = 0.0;
  double update_max_ms = 0.0;
};

/// The final alignment of the visual trajectory with the laser's, as in metrics.json.
struct ReportAlignment {
  bool accepted = false;
  std::string reason;
  std::string method;
  Eigen::Vector2d scale = Eigen::Vector2d::Ones();
  double rotation = 0.0;      ///< [rad]
  double rmse = 0.0;          ///< [m]
  double heldout_rmse = 0.0;  ///< [m]
  std::size_t pairs = 0;
  double runner_up_ratio = 0.0;
};

/// Everything the report shows. Empty parts are left out of the page or said to be missing.
struct ReportData {
  std::string version;
  std::uint64_t seed = 0;
  std::string recording;
  bool complete = true;  ///< false after an interruption
  double duration_s = 0.0;
  double wall_s = 0.0;
  double real_time_factor = 0.0;
  double peak_rss_mb = 0.0;
  common::Nanoseconds start = 0;  ///< zero of the time axes
  std::optional<common::OccupancyGrid> grid;
  std::vector<Eigen::Vector2d> landmarks;  ///< visual landmarks in the frame of the grid [m]
  StructureAndMotion visual_map;           ///< in the visual map's own frame
  std::vector<common::AnnotatedImage> sample_images;
  common::Trajectory2 truth;  ///< in the frame of the grid, drawn thin; empty without ground truth
  std::vector<ReportSource> sources;
  std::vector<ReportAccuracy> accuracy;
  std::vector<ReportModule> modules;
  std::optional<ReportAlignment> alignment;
  std::vector<common::Event> events;
};

/// The report page: self-contained HTML without scripts or external resources, inline SVG and one PNG of the grid.
/// Long series are thinned, so that the size is bounded whatever the length of the run. Every text from outside is
/// escaped. Same data, same bytes.
std::string make_report(const ReportData& data);

/// The outcome in a few plain sentences, e.g. for the header of the report and the terminal.
std::string verdict_in_words(const ReportData& data);

}  // namespace slamfuse::service
