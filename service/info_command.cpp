// SPDX-License-Identifier: BSD-3-Clause
#include "service/info_command.hpp"

#include <fmt/format.h>

#include "common/recording.hpp"
#include "common/time.hpp"
#include "service/map_bundle.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;

const char* name_of(common::SensorKind kind) {
  switch (kind) {
    case common::SensorKind::kOdometry:
      return "odometry";
    case common::SensorKind::kLaser:
      return "laser";
    case common::SensorKind::kCamera:
      return "camera";
    case common::SensorKind::kImu:
      return "imu";
    case common::SensorKind::kPose:
      return "pose";
  }
  return "";
}

std::string sensor_row(const std::string& name, const common::SensorInfo& sensor) {
  const double duration = common::to_seconds(sensor.last_stamp - sensor.first_stamp);
  const double rate = duration > 0.0 ? static_cast<double>(sensor.messages - 1) / duration : 0.0;
  return fmt::format("  {:<10} {:<10} {:>7} messages {:>8.2f} Hz   {} .. {}\n", name, name_of(sensor.kind),
                     sensor.messages, rate, common::format_seconds(sensor.first_stamp),
                     common::format_seconds(sensor.last_stamp));
}

std::string calibration_rows(const common::Calibration& calibration) {
  std::string text;
  for (const auto& [name, laser] : calibration.lasers) {
    const auto& p = laser.T_base_laser.translation;
    text += fmt::format("  {:<10} at ({:.3f}, {:.3f}, {:.3f}) m, {} beams, {:.2f} .. {:.2f} m, sweep {}\n", name, p.x(),
                        p.y(), p.z(), laser.beams, laser.range_min, laser.range_max,
                        laser.sweep_duration > 0.0 ? fmt::format("{:.4f} s", laser.sweep_duration) : "not told");
  }
  for (const auto& [name, camera] : calibration.cameras) {
    const auto& p = camera.T_base_camera.translation;
    text += fmt::format("  {:<10} at ({:.3f}, {:.3f}, {:.3f}) m, {}x{} px, focal length {:.1f} px\n", name, p.x(),
                        p.y(), p.z(), camera.width, camera.height, camera.fx);
  }
  return text;
}

common::Result<std::string> describe_recording(const fs::path& path, const common::RecordingOptions& options) {
  const auto recording = common::open_recording(path, options);
  if (!recording) return tl::unexpected(recording.error());
  const common::RecordingInfo& info = (*recording)->info();
  std::string text =
      fmt::format("recording {}\n  format {}, {:.1f} s, {}\n", path.string(), info.format,
                  common::to_seconds(info.last_stamp - info.first_stamp),
                  info.stamp_ordered ? "in the order of the stamps" : "in file order, stamps may step back");
  for (const auto& [name, sensor] : info.sensors) text += sensor_row(name, sensor);
  text += calibration_rows(info.calibration);
  for (const auto& note : info.notes) text += "  " + note + "\n";
  const auto truth = common::read_ground_truth(path, options);
  const bool has_truth = truth && !truth->empty();
  return text + (has_truth ? fmt::format("  ground truth: {} poses\n", truth->size()) : "  no ground truth\n");
}

common::Result<std::string> describe_map(const fs::path& path) {
  const auto bundle = read_map_bundle(path);
  if (!bundle) return tl::unexpected(bundle.error());
  const MapBundleSummary& summary = bundle->summary;
  std::string text =
      fmt::format("map {}\n  made by slamfuse {} with seed {} from {}{}\n", path.string(), summary.program_version,
                  summary.seed, summary.recording, summary.incomplete ? " (incomplete: the run was interrupted)" : "");
  if (bundle->grid) {
    text += fmt::format("  grid {} x {} cells of {} m\n", bundle->grid->width, bundle->grid->height,
                        bundle->grid->resolution);
  }
  text += fmt::format("  {} visual landmarks, {}\n", bundle->landmarks.size(),
                      summary.alignment ? "aligned with the laser map" : "not aligned with the laser map");
  for (const auto& file : summary.files) text += fmt::format("  {:<20} {:>10} bytes, intact\n", file.name, file.bytes);
  return text;
}

}  // namespace

common::Result<std::string> run_info(const InfoRequest& request) {
  return is_map_bundle(request.path) ? describe_map(request.path)
                                     : describe_recording(request.path, request.recording_options);
}

}  // namespace slamfuse::service
