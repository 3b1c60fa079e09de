// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_report.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/angle.hpp"
#include "service/metrics.hpp"
#include "service/update_times.hpp"

namespace slamfuse::service {
namespace {

using common::PoseSource;
using common::Trajectory2;

/// How close in time the first laser and the first odometry pose must be for the odometry to be drawn from there.
constexpr common::Nanoseconds kMaxGapToFirstPose = common::kNanosecondsPerSecond;
constexpr std::size_t kImagesToShow = 6;  // each about 25 kB of the page

const NamedAccuracy* accuracy_named(const RunSummary& summary, const std::string& name) {
  const auto found =
      std::find_if(summary.accuracy.begin(), summary.accuracy.end(), [&](const auto& row) { return row.name == name; });
  return found == summary.accuracy.end() ? nullptr : &*found;
}

const Trajectory2* trajectory_named(const RunSummary& summary, const std::string& name) {
  const auto found = std::find_if(summary.trajectories.begin(), summary.trajectories.end(),
                                  [&](const auto& row) { return row.name == name; });
  return found == summary.trajectories.end() || found->trajectory.empty() ? nullptr : &found->trajectory;
}

/// The odometry in the laser map: the two agree at the laser's first pose.
Trajectory2 odometry_from_first_laser_pose(const Trajectory2& odometry, const Trajectory2& laser) {
  const Trajectory2 sorted = common::sorted_by_stamp(odometry);
  const auto T_odom_base = common::pose_at(sorted, laser.front().stamp, kMaxGapToFirstPose);
  if (!T_odom_base) return {};
  const common::Pose2 T_map_odom = laser.front().pose * T_odom_base->inverse();
  Trajectory2 path = odometry;
  for (auto& pose : path) pose.pose = T_map_odom * pose.pose;
  return path;
}

Trajectory2 path_to_draw(const RunSummary& summary, PoseSource source) {
  const Trajectory2* path = trajectory_named(summary, common::to_string(source));
  if (path == nullptr) return {};
  const Trajectory2* laser = trajectory_named(summary, "laser");
  if (source == PoseSource::kOdometry) return laser != nullptr ? odometry_from_first_laser_pose(*path, *laser) : *path;
  if (source == PoseSource::kVisual && laser != nullptr) {
    if (!summary.alignment || !summary.alignment->accepted) return {};
    return fusion::to_laser_frame(*path, *summary.alignment);
  }
  return *path;
}

ReportSource source_of(const RunSummary& summary, PoseSource source) {
  ReportSource report;
  report.source = source;
  report.path = path_to_draw(summary, source);
  if (const auto found = summary.log.estimates.find(source); found != summary.log.estimates.end()) {
    report.estimates = found->second;
    report.states = summary.log.states.at(source);
  }
  if (const auto* row = accuracy_named(summary, common::to_string(source))) {
    for (const auto& error : row->accuracy.errors)
      report.errors.push_back({error.stamp, error.position, error.heading});
  }
  if (const auto found = summary.counters.find(source); found != summary.counters.end()) {
    for (const auto& update : found->second.updates.items())
      report.updates.push_back({update.stamp, update.milliseconds});
  }
  return report;
}

ReportModule module_of(const RunSummary& summary, PoseSource source, const ModuleCounters& counters) {
  std::vector<double> milliseconds;
  for (const auto& update : counters.updates.items()) milliseconds.push_back(update.milliseconds);
  const UpdateTimes times = summarise_update_times(std::move(milliseconds));
  ReportModule module;
  module.name = source == PoseSource::kFused ? "fusion" : common::to_string(source);
  module.inputs = counters.inputs;
  module.poses = counters.poses;
  module.dropped = counters.dropped;
  module.rejected = counters.rejected;
  module.coverage = summary.coverage.contains(source) ? summary.coverage.at(source) : 0.0;
  module.update_median_ms = times.median;
  module.update_p95_ms = times.p95;
  module.update_p99_ms = times.p99;
  module.update_max_ms = counters.slowest_ms;
  return module;
}

ReportAccuracy accuracy_of(const NamedAccuracy& row) {
  ReportAccuracy report;
  report.name = row.name;
  report.align = to_string(row.accuracy.align);
  report.ate_rmse = row.accuracy.ate_rmse_m;
  report.ate_max = row.accuracy.ate_max_m;
  report.heading_rmse = common::to_radians(row.accuracy.heading_rmse_deg);
  report.rpe_percent = row.accuracy.rpe_percent;
  report.coverage = row.accuracy.coverage;
  return report;
}

ReportAlignment alignment_of(const fusion::Alignment& alignment) {
  ReportAlignment report;
  report.accepted = alignment.accepted;
  report.reason = alignment.reason;
  report.method = to_string(alignment.method);
  report.scale = alignment.scale;
  report.rotation = common::to_radians(alignment.rotation_deg);
  report.rmse = alignment.rmse;
  report.heldout_rmse = alignment.heldout_rmse;
  report.pairs = alignment.pairs;
  report.runner_up_ratio = alignment.runner_up_ratio;
  return report;
}

std::vector<Eigen::Vector2d> landmarks_in_plan(const RunSummary& summary) {
  std::vector<Eigen::Vector2d> points;
  const bool aligned = summary.alignment && summary.alignment->accepted;
  if (summary.grid && !aligned) return points;
  for (const auto& landmark : summary.landmarks) {
    const Eigen::Vector2d point = landmark.position.head<2>();
    points.push_back(aligned ? summary.alignment->map * point : point);
  }
  return points;
}

StructureAndMotion structure_and_motion_of(const RunSummary& summary) {
  const Trajectory2* path = trajectory_named(summary, "visual_final");
  return {summary.landmarks, summary.keyframes, path == nullptr ? Trajectory2{} : *path};
}

/// So many of the images, as many of each camera and evenly over the run.
std::vector<common::AnnotatedImage> images_to_show(const std::vector<common::AnnotatedImage>& images) {
  std::map<std::string, std::vector<const common::AnnotatedImage*>> by_camera;
  for (const auto& image : images) by_camera[image.image.sensor].push_back(&image);
  std::vector<common::AnnotatedImage> chosen;
  for (const auto& [camera, all] : by_camera) {
    const std::size_t wanted = std::min(all.size(), std::max<std::size_t>(1, kImagesToShow / by_camera.size()));
    for (std::size_t i = 0; i < wanted; ++i) chosen.push_back(*all[(2 * i + 1) * all.size() / (2 * wanted)]);
  }
  return chosen;
}

/// The truth in the frame of the path the accuracy was measured with.
Trajectory2 truth_in_plan(const RunSummary& summary) {
  for (const char* name : {"laser_final", "laser", "visual"}) {
    const auto* row = accuracy_named(summary, name);
    if (row == nullptr) continue;
    const common::Similarity2 T_map_truth = row->accuracy.T_reference_estimate.inverse();
    Trajectory2 truth = summary.truth;
    for (auto& pose : truth) pose.pose = T_map_truth * pose.pose;
    return truth;
  }
  return {};
}

}  // namespace

ReportData report_of(const RunSummary& summary) {
  ReportData data;
  data.version = program_version();
  data.seed = summary.seed;
  data.recording = summary.recording;
  data.complete = !summary.incomplete;
  data.duration_s = summary.duration_s;
  data.wall_s = summary.wall_s;
  data.real_time_factor = summary.wall_s > 0.0 ? summary.duration_s / summary.wall_s : 0.0;
  data.peak_rss_mb = summary.peak_rss_mb;
  data.start = summary.first_stamp;
  data.grid = summary.grid;
  data.landmarks = landmarks_in_plan(summary);
  data.visual_map = structure_and_motion_of(summary);
  data.sample_images = images_to_show(summary.sample_images);
  data.truth = truth_in_plan(summary);
  for (const auto source : {PoseSource::kOdometry, PoseSource::kLaser, PoseSource::kVisual, PoseSource::kFused}) {
    if (summary.counters.contains(source) || summary.log.trajectories.contains(source)) {
      data.sources.push_back(source_of(summary, source));
    }
  }
  for (const auto& row : summary.accuracy) data.accuracy.push_back(accuracy_of(row));
  for (const auto& [source, counters] : summary.counters) data.modules.push_back(module_of(summary, source, counters));
  if (summary.alignment) data.alignment = alignment_of(*summary.alignment);
  data.events = summary.log.events;
  return data;
}

}  // namespace slamfuse::service
