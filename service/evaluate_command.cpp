// SPDX-License-Identifier: BSD-3-Clause
#include "service/evaluate_command.hpp"

#include <array>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/angle.hpp"
#include "common/carmen_reference.hpp"
#include "common/recording.hpp"
#include "common/relations.hpp"
#include "common/tum.hpp"
#include "service/metrics.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// What to compare with, and how the estimate must be turned into poses of the same body.
struct Reference {
  common::Trajectory2 trajectory;
  common::Pose2 T_base_body;  ///< the body whose poses the reference holds
  bool equal_stamps_only = false;
};

/// The laser's mounting according to the CARMEN log beside its reference ("intel.reference.txt": "intel.clf.bz2").
common::Pose2 laser_mounting_beside(const fs::path& reference) {
  constexpr std::array kLogEndings{".clf", ".log", ".clf.gz", ".log.gz", ".clf.bz2", ".log.bz2"};
  const fs::path stem = reference.parent_path() / reference.stem().stem();
  for (const char* ending : kLogEndings) {
    const fs::path log = stem.string() + ending;
    std::error_code error;
    if (!fs::exists(log, error)) continue;
    const auto recording = common::open_recording(log);
    if (!recording || (*recording)->info().calibration.lasers.empty()) continue;
    return common::to_pose2((*recording)->info().calibration.lasers.begin()->second.T_base_laser);
  }
  return {};
}

/// Whether a path can only be a recording: a folder, or a bag.
bool is_recording(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error) || common::is_ros_bag(path);
}

common::Result<Reference> read_reference(const fs::path& path, const common::RecordingOptions& recording_options) {
  Reference reference;
  if (is_recording(path)) {
    auto truth = common::read_ground_truth(path, recording_options);
    if (!truth) return tl::unexpected(truth.error());
    if (truth->empty()) return common::invalid_input(path.string() + ": a recording without ground truth");
    reference.trajectory = common::sorted_by_stamp(*truth);
    return reference;
  }
  if (common::is_carmen_reference(path)) {
    auto laser_poses = common::read_carmen_reference(path);
    if (!laser_poses) return tl::unexpected(laser_poses.error());
    reference.trajectory = std::move(*laser_poses);
    reference.T_base_body = laser_mounting_beside(path);
    reference.equal_stamps_only = true;
    return reference;
  }
  const auto trajectory = common::read_trajectory(path);
  if (!trajectory) return tl::unexpected(trajectory.error());
  reference.trajectory = common::sorted_by_stamp(common::to_planar(*trajectory));
  return reference;
}

common::Result<common::Trajectory2> read_estimate(const fs::path& path) {
  const auto trajectory = common::read_trajectory(path);
  if (!trajectory) return tl::unexpected(trajectory.error());
  return common::to_planar(*trajectory);
}

common::Result<common::TrajectoryAccuracy> compare(const fs::path& estimate_path, const fs::path& reference_path,
                                                   common::EvaluationOptions options,
                                                   const common::RecordingOptions& recording_options) {
  const auto estimate = read_estimate(estimate_path);
  if (!estimate) return tl::unexpected(estimate.error());
  const auto reference = read_reference(reference_path, recording_options);
  if (!reference) return tl::unexpected(reference.error());
  if (reference->equal_stamps_only) options.max_reference_gap = 0;
  return common::evaluate_trajectory(common::sensor_trajectory(*estimate, reference->T_base_body),
                                     reference->trajectory, options);
}

common::Result<common::TrajectoryAccuracy> accuracy_of(const EvaluateRequest& request) {
  common::EvaluationOptions options;
  options.align = request.align;
  options.fit_offset = request.fit_offset;
  if (request.align_as) {
    const auto fitted = compare(request.align_as->first, request.align_as->second, options, request.recording_options);
    if (!fitted) return tl::unexpected(fitted.error());
    options.align = common::EvaluationAlignment::kAs;
    options.T_reference_estimate = fitted->T_reference_estimate;
  }
  return compare(request.estimate, *request.reference, options, request.recording_options);
}

common::Result<common::RelationAccuracy> relations_of(const EvaluateRequest& request) {
  const auto estimate = read_estimate(request.estimate);
  if (!estimate) return tl::unexpected(estimate.error());
  const auto relations = common::read_relations(*request.relations);
  if (!relations) return tl::unexpected(relations.error());
  return common::evaluate_relations(*estimate, *relations);
}

/// The fitted offsets, where some were.
std::string offset_rows(const common::TrajectoryAccuracy& accuracy) {
  const common::Pose2& body = accuracy.T_base_body;
  return fmt::format(
      "tracked body   at ({:.4f}, {:.4f}) m, {:.3f} deg in base_link\n"
      "clocks         {:+.4f} s from estimate to reference\n",
      body.x, body.y, common::to_degrees(body.theta), common::to_seconds(accuracy.clock_offset));
}

std::string table(const common::TrajectoryAccuracy& accuracy) {
  const std::string rpe = accuracy.rpe_percent ? fmt::format("{:.3f} %", *accuracy.rpe_percent) : "path too short";
  return fmt::format(
      "alignment      {}\n"
      "compared       {} poses\n"
      "ATE rmse       {:.4f} m\n"
      "ATE max        {:.4f} m\n"
      "heading rmse   {:.4f} deg\n"
      "RPE over {:.0f} m   {}\n"
      "coverage       {:.4f}\n",
      to_string(accuracy.align), accuracy.errors.size(), accuracy.ate_rmse_m, accuracy.ate_max_m,
      accuracy.heading_rmse_deg, common::kSubPathLength, rpe, accuracy.coverage);
}

std::string row(const char* name, const common::RelationErrors& errors) {
  return fmt::format("{:<10} {:>8} {:>10.4f} +- {:<10.4f} {:>9.4f} +- {:<.4f}\n", name, errors.matched,
                     errors.translation_m.mean, errors.translation_m.deviation, errors.rotation_deg.mean,
                     errors.rotation_deg.deviation);
}

std::string table(const common::RelationAccuracy& accuracy) {
  return fmt::format("relations   matched  translation [m]          rotation [deg]\n{}{}{} without a pose\n",
                     row("all", accuracy.all), row("over 60 s", accuracy.distant), accuracy.missing);
}

ordered_json metrics_of(const common::RelationErrors& errors) {
  const auto pair = [](const common::MeanAndDeviation& value) {
    return ordered_json{{"mean", value.mean}, {"deviation", value.deviation}};
  };
  return {{"matched", errors.matched},
          {"translation_m", pair(errors.translation_m)},
          {"translation_squared_m2", pair(errors.translation_squared_m2)},
          {"rotation_deg", pair(errors.rotation_deg)},
          {"rotation_squared_deg2", pair(errors.rotation_squared_deg2)}};
}

}  // namespace

common::Result<std::string> run_evaluate(const EvaluateRequest& request) {
  std::string text;
  ordered_json json;
  if (request.reference) {
    const auto accuracy = accuracy_of(request);
    if (!accuracy) return tl::unexpected(accuracy.error());
    text += table(*accuracy);
    json = accuracy_metrics(*accuracy);
    if (request.fit_offset) {
      text += offset_rows(*accuracy);
      json["tracked_body"] = {accuracy->T_base_body.x, accuracy->T_base_body.y, accuracy->T_base_body.theta};
      json["clock_offset_s"] = common::to_seconds(accuracy->clock_offset);
    }
  }
  if (request.relations) {
    const auto relations = relations_of(request);
    if (!relations) return tl::unexpected(relations.error());
    text += table(*relations);
    json["relations"] = {{"all", metrics_of(relations->all)},
                         {"distant", metrics_of(relations->distant)},
                         {"missing", relations->missing}};
  }
  return request.json ? json_text(json) : text;
}

}  // namespace slamfuse::service
