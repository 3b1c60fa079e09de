// SPDX-License-Identifier: BSD-3-Clause
#include "common/carmen_recording.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "common/carmen_line.hpp"
#include "common/carmen_reference.hpp"
#include "common/laser_reading.hpp"
#include "common/line_reader.hpp"
#include "common/recording_span.hpp"
#include "common/text_fields.hpp"

namespace slamfuse::common {
namespace {

constexpr const char* kLaserName = "laser0";
constexpr const char* kOdometryName = "odom0";

/// FLASER does not say how far the laser sees. The SICK lasers of the public logs write 81.83 or 81.91 m (or 50.00 m in
/// older conversions) for a beam that saw nothing, and nothing between 50 and 80 m.
constexpr double kFlaserRangeMax = 50.0;

/// A laser pose that moves by more than this against the robot pose [m, rad] is no mounting but a corrected pose.
constexpr double kMountingTolerance = 0.01;

enum class ScanKind { kFlaser, kRobotLaser1 };

std::optional<ScanKind> scan_kind(std::string_view keyword) {
  if (keyword == "FLASER") return ScanKind::kFlaser;
  if (keyword == "ROBOTLASER1") return ScanKind::kRobotLaser1;
  return std::nullopt;
}

Result<CarmenScan> parse_scan(ScanKind kind, const std::vector<std::string_view>& words) {
  return kind == ScanKind::kFlaser ? parse_flaser(words) : parse_robotlaser1(words);
}

/// Every CARMEN message is an upper-case word; which of the many kinds there are does not matter here.
bool is_keyword(std::string_view word) {
  return std::all_of(word.begin(), word.end(),
                     [](char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-'; });
}

/// What a log tells of its scans with one number of readings.
struct BeamSurvey {
  std::size_t scans = 0;
  std::optional<CarmenBeams> beams;
  Pose2 mounting;  ///< T_base_laser of the first scan
  bool mounting_constant = true;
  Nanoseconds first_stamp = 0;
  Nanoseconds last_stamp = 0;

  void add(const CarmenScan& scan) {
    const Pose2 offset = scan.robot_pose.inverse() * scan.laser_pose;
    if (scans++ == 0) {
      beams = scan.beams;
      mounting = offset;
      first_stamp = last_stamp = scan.stamp;
    }
    const Pose2 change = mounting.inverse() * offset;
    mounting_constant = mounting_constant && std::hypot(change.x, change.y) <= kMountingTolerance &&
                        std::abs(change.theta) <= kMountingTolerance;
    first_stamp = std::min(first_stamp, scan.stamp);
    last_stamp = std::max(last_stamp, scan.stamp);
  }
};

struct Survey {
  std::map<ScanKind, std::map<std::size_t, BeamSurvey>> scans;  ///< by kind and number of readings
  std::optional<double> front_laser_offset;                     ///< [m] forward of base_link
  std::optional<double> front_laser_max;                        ///< [m]
};

void add_parameter(const std::vector<std::string_view>& words, Survey& survey) {
  if (words.size() < 3) return;
  const std::optional<double> value = parse_real(words[2]);
  if (!value) return;
  if (words[1] == "robot_frontlaser_offset") survey.front_laser_offset = *value;
  if (words[1] == "robot_front_laser_max" && *value > 0.0) survey.front_laser_max = *value;
}

/// Reads the whole log. Data that ends early is not an error here: next() tells of it when it comes to that place.
Result<Survey> survey_log(const std::filesystem::path& path) {
  Result<LineReader> lines = open_lines(path);
  if (!lines) return tl::unexpected(lines.error());
  Survey survey;
  std::vector<std::string_view> words;
  while (true) {
    const Result<std::optional<LineReader::Line>> line = lines->next();
    if (!line && survey.scans.empty()) return tl::unexpected(line.error());
    if (!line || !*line) return survey;
    if ((*line)->too_long) continue;
    split_at_blanks((*line)->text, words);
    if (words.empty()) continue;
    if (words.front() == "PARAM") add_parameter(words, survey);
    const std::optional<ScanKind> kind = scan_kind(words.front());
    if (!kind) continue;
    const Result<CarmenScan> scan = parse_scan(*kind, words);
    if (scan) survey.scans[*kind][scan->readings.size()].add(*scan);
  }
}

LaserCalibration calibration_from(std::size_t readings, const BeamSurvey& scans, const Survey& survey) {
  const CarmenBeams beams =
      scans.beams.value_or(flaser_beams(readings, survey.front_laser_max.value_or(kFlaserRangeMax)));
  LaserCalibration laser;
  const Pose2 told{survey.front_laser_offset.value_or(0.0), 0.0, 0.0};
  laser.T_base_laser = to_pose3(scans.mounting_constant ? scans.mounting : told);
  laser.angle_min = beams.angle_min;
  laser.angle_increment = beams.angle_increment;
  laser.beams = static_cast<int>(readings);
  laser.range_max = beams.range_max;
  return laser;
}

class CarmenRecording final : public Recording {
 public:
  CarmenRecording(RecordingInfo info, ScanKind kind, std::optional<CarmenBeams> beams, LineReader lines)
      : info_(std::move(info)),
        kind_(kind),
        beams_(beams),
        laser_(info_.calibration.lasers.at(kLaserName)),
        lines_(std::move(lines)),
        last_stamp_(info_.first_stamp) {}

  const RecordingInfo& info() const override { return info_; }

  Result<std::optional<RecordingItem>> next() override {
    while (ready_.empty() && !ended_) read_line();
    if (ready_.empty()) return std::nullopt;
    RecordingItem item = std::move(ready_.front());
    ready_.pop_front();
    return item;
  }

 private:
  void read_line() {
    const Result<std::optional<LineReader::Line>> line = lines_.next();
    ended_ = !line || !*line;
    if (!line) ready_.emplace_back(RejectedMessage{last_stamp_, kLaserName, line.error().message});
    if (ended_) return;
    const std::string where = info_.path.string() + ":" + std::to_string((*line)->number) + ": ";
    if ((*line)->too_long) {
      return reject(where + "line longer than " + std::to_string(LineReader::kLongestLine) + " characters");
    }
    split_at_blanks((*line)->text, words_);
    if (words_.empty() || words_.front().front() == '#') return;
    if (!is_keyword(words_.front())) return reject(where + in_quotes((*line)->text) + " is not a CARMEN message");
    if (scan_kind(words_.front()) != kind_) return;

    const Result<CarmenScan> scan = parse_scan(kind_, words_);
    if (!scan) return reject(where + scan.error().message);
    if (scan->readings.size() != static_cast<std::size_t>(laser_.beams)) {
      return reject(where + std::to_string(scan->readings.size()) +
                    " readings (allowed: " + std::to_string(laser_.beams) + " as in most scans of the log)");
    }
    if (scan->beams != beams_) return reject(where + "other angles or maximum range than the first scan");
    add_messages(*scan);
  }

  void reject(std::string reason) { ready_.emplace_back(RejectedMessage{last_stamp_, kLaserName, std::move(reason)}); }

  void add_messages(const CarmenScan& scan) {
    last_stamp_ = scan.stamp;
    ready_.emplace_back(WheelOdometry{scan.stamp, kOdometryName, scan.robot_pose, scan.forward_speed, scan.turn_rate});
    LaserScan message{scan.stamp, kLaserName, {}};
    message.ranges.reserve(scan.readings.size());
    for (const double reading : scan.readings) {
      message.ranges.push_back(reading >= laser_.range_max ? kBeyondRange : as_range(reading, laser_));
    }
    ready_.emplace_back(std::move(message));
  }

  RecordingInfo info_;
  ScanKind kind_;
  std::optional<CarmenBeams> beams_;
  LaserCalibration laser_;
  LineReader lines_;
  std::vector<std::string_view> words_;
  std::deque<RecordingItem> ready_;  ///< messages of the last line read
  Nanoseconds last_stamp_;
  bool ended_ = false;
};

}  // namespace

bool is_carmen_log(std::string_view beginning) {
  constexpr std::array<std::string_view, 9> kMessages{"FLASER",    "RLASER",    "ROBOTLASER1", "ROBOTLASER2", "ODOM",
                                                      "RAWLASER1", "RAWLASER2", "PARAM",       "SYNC"};
  constexpr std::size_t kFewestWords = 4;
  std::vector<std::string_view> words;
  while (!beginning.empty()) {
    const std::size_t end = beginning.find('\n');
    split_at_blanks(beginning.substr(0, end), words);
    if (words.size() >= kFewestWords &&
        std::find(kMessages.begin(), kMessages.end(), words.front()) != kMessages.end()) {
      return true;
    }
    if (end == std::string_view::npos) return false;
    beginning.remove_prefix(end + 1);
  }
  return false;
}

Result<std::unique_ptr<Recording>> open_carmen_recording(const std::filesystem::path& path) {
  const Result<Survey> survey = survey_log(path);
  if (!survey) return tl::unexpected(survey.error());
  if (survey->scans.empty()) {
    return invalid_input(path.string() + ": no scan that can be used (expected: FLASER or ROBOTLASER1 messages)");
  }
  // ROBOTLASER1 comes last in the map and tells more than FLASER, so it goes before if a log has both.
  const auto& [kind, by_readings] = *survey->scans.rbegin();
  const auto& [readings, scans] =
      *std::max_element(by_readings.begin(), by_readings.end(),
                        [](const auto& a, const auto& b) { return a.second.scans < b.second.scans; });

  RecordingInfo info;
  info.path = path;
  info.format = "carmen";
  info.stamp_ordered = false;
  info.sensors[kOdometryName] = {SensorKind::kOdometry, scans.scans, scans.first_stamp, scans.last_stamp};
  info.sensors[kLaserName] = {SensorKind::kLaser, scans.scans, scans.first_stamp, scans.last_stamp};
  info.calibration.lasers[kLaserName] = calibration_from(readings, scans, *survey);
  const Result<void> span = set_time_span(info);
  if (!span) return tl::unexpected(span.error());
  Result<LineReader> lines = open_lines(path);
  if (!lines) return tl::unexpected(lines.error());
  return std::make_unique<CarmenRecording>(std::move(info), kind, scans.beams, std::move(*lines));
}

Result<Trajectory2> read_carmen_ground_truth(const std::filesystem::path& path) {
  std::filesystem::path file = path;
  for (const char* extension : {".bz2", ".gz", ".clf", ".log"}) {
    if (file.extension() == extension) file.replace_extension();
  }
  file += ".reference.txt";
  std::error_code code;
  if (!std::filesystem::exists(file, code)) return Trajectory2{};

  const Result<std::unique_ptr<Recording>> log = open_carmen_recording(path);
  if (!log) return tl::unexpected(log.error());
  const Result<Trajectory2> laser_poses = read_carmen_reference(file);
  if (!laser_poses) return tl::unexpected(laser_poses.error());
  const Pose2 T_base_laser = to_pose2((*log)->info().calibration.lasers.at(kLaserName).T_base_laser);
  return sensor_trajectory(*laser_poses, T_base_laser.inverse());
}

}  // namespace slamfuse::common
