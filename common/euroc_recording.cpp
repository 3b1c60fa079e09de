// SPDX-License-Identifier: BSD-3-Clause
#include "common/euroc_recording.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "common/euroc_rows.hpp"
#include "common/recording_span.hpp"
#include "common/sensor_yaml.hpp"
#include "common/stamped_csv.hpp"
#include "common/text_fields.hpp"

namespace slamfuse::common {
namespace {

namespace fs = std::filesystem;

/// A kind of sensor folder, in the order in which messages of equal stamp come out.
struct FolderKind {
  std::string_view prefix;
  SensorKind kind;
  CsvColumns columns;
};

const std::array<FolderKind, 4>& folder_kinds() {
  static const std::array<FolderKind, 4> kinds{
      {{"odom", SensorKind::kOdometry, {{"timestamp", "x", "y", "theta", "v", "omega"}, 4}},
       {"imu",
        SensorKind::kImu,
        {{"timestamp", "w_RS_S_x", "w_RS_S_y", "w_RS_S_z", "a_RS_S_x", "a_RS_S_y", "a_RS_S_z"}, 7}},
       {"laser", SensorKind::kLaser, {{"timestamp", "ranges"}, 2}},
       {"cam", SensorKind::kCamera, {{"timestamp", "filename"}, 2}}}};
  return kinds;
}

struct SensorFolder {
  std::string name;
  fs::path path;
  const FolderKind* kind = nullptr;
};

const FolderKind* kind_of_folder(std::string_view name) {
  for (const FolderKind& kind : folder_kinds()) {
    if (!name.starts_with(kind.prefix)) continue;
    const std::string_view number = name.substr(kind.prefix.size());
    if (!number.empty() && number.find_first_not_of("0123456789") == std::string_view::npos) return &kind;
  }
  return nullptr;
}

/// The sensor folders in the order of kind and name.
std::vector<SensorFolder> find_sensor_folders(const fs::path& root) {
  std::vector<SensorFolder> folders;
  std::error_code code;
  for (fs::directory_iterator entry(root, code); !code && entry != fs::directory_iterator(); entry.increment(code)) {
    const std::string name = entry->path().filename().string();
    const FolderKind* const kind = kind_of_folder(name);
    std::error_code status_code;
    if (kind != nullptr && entry->is_directory(status_code)) folders.push_back({name, entry->path(), kind});
  }
  std::sort(folders.begin(), folders.end(), [](const SensorFolder& a, const SensorFolder& b) {
    return std::tuple(a.kind, a.name.size(), a.name) < std::tuple(b.kind, b.name.size(), b.name);
  });
  return folders;
}

/// EuRoC archives put all sensors into a folder `mav0`.
fs::path root_of(const fs::path& path) {
  std::error_code code;
  return fs::is_directory(path / "mav0", code) ? path / "mav0" : path;
}

struct Sensor {
  std::string name;
  StampedCsv csv;
  std::function<Result<SensorMessage>(const StampedRow&)> read_row;
  std::optional<StampedRow> pending;  ///< the row whose turn comes next
};

/// Reads through the stamps of a data.csv.
Result<SensorInfo> survey(const fs::path& path, const FolderKind& kind) {
  Result<StampedCsv> csv = StampedCsv::open(path, kind.columns);
  if (!csv) return tl::unexpected(csv.error());
  SensorInfo info;
  info.kind = kind.kind;
  std::size_t bad_rows = 0;
  std::string first_problem;
  while (true) {
    const Result<std::optional<StampedRow>> row = csv->next();
    if (!row) return tl::unexpected(row.error());
    if (!*row) break;
    if (!(*row)->problem.empty()) {
      if (bad_rows++ == 0) first_problem = ":" + std::to_string((*row)->line) + ": " + (*row)->problem;
      continue;
    }
    if (info.messages++ == 0) info.first_stamp = (*row)->stamp;
    info.last_stamp = (*row)->stamp;
  }
  if (info.messages == 0 && bad_rows > 0) {
    return invalid_input(path.string() + first_problem + "; no row has a usable stamp");
  }
  return info;
}

Result<Sensor> open_sensor(const SensorFolder& folder, Calibration& calibration) {
  Result<StampedCsv> csv = StampedCsv::open(folder.path / "data.csv", folder.kind->columns);
  if (!csv) return tl::unexpected(csv.error());
  Sensor sensor{folder.name, std::move(*csv), {}, {}};
  const std::string& name = folder.name;
  switch (folder.kind->kind) {
    case SensorKind::kOdometry:
      sensor.read_row = [name](const StampedRow& row) { return read_odometry_row(row, name); };
      break;
    case SensorKind::kImu:
      sensor.read_row = [name](const StampedRow& row) { return read_imu_row(row, name); };
      break;
    case SensorKind::kLaser: {
      const Result<LaserCalibration> laser = read_laser_yaml(folder.path / "sensor.yaml");
      if (!laser) return tl::unexpected(laser.error());
      calibration.lasers[name] = *laser;
      sensor.read_row = [name, laser = *laser](const StampedRow& row) { return read_laser_row(row, name, laser); };
      break;
    }
    case SensorKind::kCamera: {
      const Result<CameraYaml> camera = read_camera_yaml(folder.path / "sensor.yaml");
      if (!camera) return tl::unexpected(camera.error());
      calibration.cameras[name] = camera->calibration;
      sensor.read_row = [name, camera = camera->calibration, images = folder.path / "data"](const StampedRow& row) {
        return read_camera_row(row, name, camera, images);
      };
      break;
    }
    case SensorKind::kPose:
      break;
  }
  return sensor;
}

class EurocRecording final : public Recording {
 public:
  EurocRecording(RecordingInfo info, std::vector<Sensor> sensors)
      : info_(std::move(info)), sensors_(std::move(sensors)) {}

  const RecordingInfo& info() const override { return info_; }

  Result<std::optional<RecordingItem>> next() override {
    Sensor* earliest = nullptr;
    for (Sensor& sensor : sensors_) {
      if (!sensor.pending) {
        Result<std::optional<StampedRow>> row = sensor.csv.next();
        if (!row) return tl::unexpected(row.error());
        sensor.pending = std::move(*row);
      }
      if (!sensor.pending) continue;
      // The sensors are in the order in which equal stamps come out, so only an earlier stamp goes before.
      if (earliest == nullptr || sensor.pending->stamp < earliest->pending->stamp) earliest = &sensor;
    }
    if (earliest == nullptr) return std::nullopt;
    const StampedRow row = std::move(*earliest->pending);
    earliest->pending.reset();
    return item_from(*earliest, row);
  }

 private:
  RecordingItem item_from(const Sensor& sensor, const StampedRow& row) const {
    std::string problem = row.problem;
    if (problem.empty()) {
      Result<SensorMessage> message = sensor.read_row(row);
      if (message) return std::move(*message);
      problem = message.error().message;
    }
    return RejectedMessage{std::max(row.stamp, info_.first_stamp), sensor.name,
                           sensor.csv.path().string() + ":" + std::to_string(row.line) + ": " + problem};
  }

  RecordingInfo info_;
  std::vector<Sensor> sensors_;
};

}  // namespace

bool is_euroc_folder(const std::filesystem::path& path) { return !find_sensor_folders(root_of(path)).empty(); }

Result<std::unique_ptr<Recording>> open_euroc_recording(const std::filesystem::path& path) {
  RecordingInfo info;
  info.path = path;
  info.format = "euroc";
  std::vector<Sensor> sensors;
  for (const SensorFolder& folder : find_sensor_folders(root_of(path))) {
    Result<Sensor> sensor = open_sensor(folder, info.calibration);
    if (!sensor) return tl::unexpected(sensor.error());
    sensors.push_back(std::move(*sensor));
    const Result<SensorInfo> surveyed = survey(folder.path / "data.csv", *folder.kind);
    if (!surveyed) return tl::unexpected(surveyed.error());
    info.sensors[folder.name] = *surveyed;
  }
  const Result<void> span = set_time_span(info);
  if (!span) return tl::unexpected(span.error());
  return std::make_unique<EurocRecording>(std::move(info), std::move(sensors));
}

Result<Trajectory2> read_euroc_ground_truth(const std::filesystem::path& path) {
  const fs::path file = root_of(path) / "state_groundtruth_estimate0" / "data.csv";
  std::error_code code;
  if (!fs::exists(file, code)) return Trajectory2{};
  // EuRoC names its columns p_RS_R_x, q_RS_w and so on, so only the stamp is checked by name.
  constexpr std::size_t kPoseColumns = 8;
  Result<StampedCsv> csv = StampedCsv::open(file, {{"timestamp"}, 1});
  if (!csv) return tl::unexpected(csv.error());
  Trajectory2 truth;
  std::vector<std::string_view> fields;
  while (true) {
    const Result<std::optional<StampedRow>> row = csv->next();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return truth;
    const std::string where = file.string() + ":" + std::to_string((*row)->line) + ": ";
    if (!(*row)->problem.empty()) return invalid_input(where + (*row)->problem);
    split_at_commas((*row)->text, fields);
    std::array<double, kPoseColumns - 1> n{};
    for (std::size_t i = 0; i < n.size(); ++i) {
      const std::optional<double> number = i < fields.size() ? parse_real(fields[i]) : std::nullopt;
      if (!number) {
        return invalid_input(where + "value " + std::to_string(i + 1) +
                             " behind the stamp (expected: a position and a " + "quaternion w, x, y, z)");
      }
      n[i] = *number;
    }
    const Eigen::Quaterniond rotation(n[3], n[4], n[5], n[6]);
    if (std::abs(rotation.norm() - 1.0) > 1e-2) {
      return invalid_input(where + "quaternion of length " + std::to_string(rotation.norm()) + " (allowed: 1)");
    }
    truth.push_back({(*row)->stamp, to_pose2(Pose3{{n[0], n[1], n[2]}, rotation.normalized()})});
  }
}

}  // namespace slamfuse::common
