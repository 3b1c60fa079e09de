// SPDX-License-Identifier: BSD-3-Clause
#include "common/rawlog_recording.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "common/laser_reading.hpp"
#include "common/rawlog_entries.hpp"
#include "common/recording_span.hpp"

namespace slamfuse::common {
namespace {

constexpr const char* kOdometryName = "odom0";
constexpr std::size_t kFewestReadings = 2;
constexpr std::size_t kMostReadings = 100'000;
/// Geometry repeated with every scan may differ by rounding, not by more [m, rad].
constexpr double kGeometryTolerance = 1e-4;

bool same_geometry(const LaserCalibration& a, const LaserCalibration& b) {
  const Pose3 change = a.T_base_laser.inverse() * b.T_base_laser;
  return a.beams == b.beams && std::abs(a.angle_min - b.angle_min) < kGeometryTolerance &&
         std::abs(a.range_max - b.range_max) < kGeometryTolerance && change.translation.norm() < kGeometryTolerance &&
         change.rotation.vec().norm() < kGeometryTolerance;
}

/// Why a scan's stated geometry cannot be used; empty when it can.
std::string geometry_problem(const LaserCalibration& laser, std::size_t readings) {
  if (readings < kFewestReadings || readings > kMostReadings) {
    return "scan of " + std::to_string(readings) + " readings (allowed: " + std::to_string(kFewestReadings) + " to " +
           std::to_string(kMostReadings) + ")";
  }
  constexpr double kFullTurn = 2.0 * std::numbers::pi * (1.0 + kGeometryTolerance);
  const bool possible = laser.angle_increment > 0.0 && -2.0 * laser.angle_min <= kFullTurn && laser.range_max > 0.0 &&
                        std::isfinite(laser.range_max) && laser.T_base_laser.is_finite();
  return possible ? "" : "scan with an impossible aperture, maximum range or mounting";
}

/// The entries of a rawlog as messages, front to back.
class RawlogReader {
 public:
  /// `odometry_from_actions`: whether sensory frames get the odometry summed from the actions before them.
  RawlogReader(RawlogEntries entries, std::string file, bool odometry_from_actions)
      : entries_(std::move(entries)), file_(std::move(file)), odometry_from_actions_(odometry_from_actions) {}

  std::optional<RecordingItem> next() {
    while (ready_.empty() && !ended_) read_entry();
    if (ready_.empty()) return std::nullopt;
    RecordingItem item = std::move(ready_.front());
    ready_.pop_front();
    return item;
  }

  bool saw_actions() const { return saw_actions_; }
  const std::map<std::string, LaserCalibration>& lasers() const { return lasers_; }

 private:
  void read_entry() {
    const Result<std::optional<RawlogEntry>> entry = entries_.next();
    ended_ = !entry || !*entry;
    if (!ended_ || !entry) ++entry_;
    if (!entry) return reject(last_sensor_, last_stamp_, entry.error().message);
    if (ended_) return;
    if (const auto* action = std::get_if<RawlogAction>(&**entry)) {
      integrate(*action);
    } else {
      add_observations(std::get<RawlogObservations>(**entry));
    }
  }

  void integrate(const RawlogAction& action) {
    saw_actions_ = true;
    if (!action.step.is_finite()) return reject(kOdometryName, last_stamp_, "odometry step that is not finite");
    odometry_.pose = odometry_.pose * action.step;
    odometry_.forward_speed = action.forward_speed;
    odometry_.turn_rate = action.turn_rate;
  }

  void add_observations(const RawlogObservations& entry) {
    bool odometry_due = entry.is_frame && odometry_from_actions_;
    std::size_t unlabelled = 0;
    for (const auto& observation : entry.observations) {
      if (const auto* odometry = std::get_if<RawlogOdometry>(&observation)) {
        add_odometry(*odometry);
        continue;
      }
      const RawlogScan& scan = std::get<RawlogScan>(observation);
      if (odometry_due) {
        // The odometry of an action/observation rawlog has no stamp: it is that of the frame's first scan.
        odometry_.stamp = scan.stamp;
        add_odometry(odometry_);
        odometry_due = false;
      }
      // Scans without a label are told apart by their order in the frame.
      add_scan(scan, scan.label.empty() ? std::to_string(unlabelled++) : "label " + scan.label);
    }
  }

  void add_odometry(const RawlogOdometry& odometry) {
    if (!accept_stamp(kOdometryName, odometry.stamp)) return;
    if (!odometry.pose.is_finite() || !std::isfinite(odometry.forward_speed) || !std::isfinite(odometry.turn_rate)) {
      return reject(kOdometryName, *odometry.stamp, "odometry that is not finite");
    }
    ready_.emplace_back(SensorMessage(
        WheelOdometry{*odometry.stamp, kOdometryName, odometry.pose, odometry.forward_speed, odometry.turn_rate}));
  }

  void add_scan(const RawlogScan& scan, const std::string& label) {
    const std::string& name = names_.try_emplace(label, "laser" + std::to_string(names_.size())).first->second;
    if (!accept_stamp(name, scan.stamp)) return;
    const std::string problem = geometry_problem(scan.geometry, scan.readings.size());
    if (!problem.empty()) return reject(name, *scan.stamp, problem);
    const LaserCalibration& laser = lasers_.try_emplace(name, scan.geometry).first->second;
    if (!same_geometry(laser, scan.geometry)) {
      return reject(name, *scan.stamp,
                    "scan with another number of readings, aperture, maximum range or mounting than the first");
    }

    LaserScan message{*scan.stamp, name, {}};
    message.ranges.reserve(scan.readings.size());
    for (std::size_t i = 0; i < scan.readings.size(); ++i) {
      const double reading = scan.readings[i];
      if (scan.valid[i] && (!std::isfinite(reading) || reading < 0.0)) {
        return reject(name, *scan.stamp, "valid range " + std::to_string(reading) + " (allowed: finite, 0 and above)");
      }
      if (reading >= laser.range_max) {
        message.ranges.push_back(kBeyondRange);
      } else {
        message.ranges.push_back(scan.valid[i] ? as_range(reading, laser) : kNoMeasurement);
      }
    }
    ready_.emplace_back(SensorMessage(std::move(message)));
  }

  /// Stamps of one sensor rise; a message whose stamp does not is rejected here.
  bool accept_stamp(const std::string& sensor, std::optional<Nanoseconds> stamp) {
    const auto last = last_stamps_.find(sensor);
    if (!stamp) {
      reject(sensor, last == last_stamps_.end() ? last_stamp_ : last->second, "no usable stamp");
      return false;
    }
    if (last != last_stamps_.end() && *stamp <= last->second) {
      reject(sensor, last->second,
             "stamp " + std::to_string(*stamp) + (*stamp == last->second ? " repeats" : " steps back") +
                 " (allowed: rising stamps)");
      return false;
    }
    last_stamps_[sensor] = last_stamp_ = *stamp;
    last_sensor_ = sensor;
    return true;
  }

  void reject(const std::string& sensor, Nanoseconds stamp, const std::string& problem) {
    ready_.emplace_back(RejectedMessage{stamp, sensor, file_ + ": entry " + std::to_string(entry_) + ": " + problem});
  }

  RawlogEntries entries_;
  std::string file_;
  bool odometry_from_actions_;
  bool saw_actions_ = false;
  bool ended_ = false;
  std::size_t entry_ = 0;
  std::deque<RecordingItem> ready_;
  std::map<std::string, std::string> names_;  ///< sensor names by label
  std::map<std::string, LaserCalibration> lasers_;
  std::map<std::string, Nanoseconds> last_stamps_;
  Nanoseconds last_stamp_ = 0;
  std::string last_sensor_ = kOdometryName;
  RawlogOdometry odometry_;  ///< summed from the actions so far
};

Result<RawlogReader> open_reader(const std::filesystem::path& path, bool odometry_from_actions) {
  Result<RawlogEntries> entries = RawlogEntries::open(path);
  if (!entries) return tl::unexpected(entries.error());
  return RawlogReader(std::move(*entries), path.string(), odometry_from_actions);
}

class RawlogRecording final : public Recording {
 public:
  RawlogRecording(RecordingInfo info, RawlogReader reader) : info_(std::move(info)), reader_(std::move(reader)) {}
  const RecordingInfo& info() const override { return info_; }

  Result<std::optional<RecordingItem>> next() override {
    std::optional<RecordingItem> item = reader_.next();
    if (item) {
      if (auto* rejected = std::get_if<RejectedMessage>(&*item)) {
        rejected->stamp = std::max(rejected->stamp, info_.first_stamp);
      }
    }
    return item;
  }

 private:
  RecordingInfo info_;
  RawlogReader reader_;
};

/// Reads all messages and fills in what `info` says of them. Returns the reason of the last rejected one.
std::string survey(RawlogReader& reader, RecordingInfo& info) {
  std::string rejected;
  while (const std::optional<RecordingItem> item = reader.next()) {
    if (const auto* bad = std::get_if<RejectedMessage>(&*item)) {
      rejected = bad->reason;
      continue;
    }
    const SensorMessage& message = std::get<SensorMessage>(*item);
    SensorInfo& sensor = info.sensors[sensor_of(message)];
    sensor.kind = std::holds_alternative<LaserScan>(message) ? SensorKind::kLaser : SensorKind::kOdometry;
    sensor.last_stamp = stamp_of(message);
    if (sensor.messages++ == 0) sensor.first_stamp = sensor.last_stamp;
  }
  info.calibration.lasers = reader.lasers();
  return rejected;
}

}  // namespace

bool is_rawlog(std::string_view beginning) {
  // An object begins with the length of its class name, the highest bit set, then the name, perhaps with its namespace.
  constexpr unsigned kLengthMask = 0x7F;
  if (beginning.empty() || (static_cast<unsigned char>(beginning.front()) & ~kLengthMask) == 0) return false;
  std::string_view name = beginning.substr(1, static_cast<unsigned char>(beginning.front()) & kLengthMask);
  constexpr std::string_view kNamespace = "mrpt::obs::";
  if (name.starts_with(kNamespace)) name.remove_prefix(kNamespace.size());
  return name == "CActionCollection" || name == "CSensoryFrame" || name.starts_with("CObservation");
}

Result<std::unique_ptr<Recording>> open_rawlog_recording(const std::filesystem::path& path) {
  bool odometry_from_actions = true;
  while (true) {
    RecordingInfo info;
    info.path = path;
    info.format = "rawlog";
    Result<RawlogReader> reader = open_reader(path, odometry_from_actions);
    if (!reader) return tl::unexpected(reader.error());
    const std::string rejected = survey(*reader, info);
    if (odometry_from_actions && !reader->saw_actions()) {
      // Without a single action the integrated odometry would say that the robot never moves.
      odometry_from_actions = false;
      continue;
    }
    if (info.sensors.empty() && !rejected.empty()) return invalid_input(rejected);
    const Result<void> span = set_time_span(info);
    if (!span) return tl::unexpected(span.error());
    Result<RawlogReader> again = open_reader(path, odometry_from_actions);
    if (!again) return tl::unexpected(again.error());
    return std::make_unique<RawlogRecording>(std::move(info), std::move(*again));
  }
}

}  // namespace slamfuse::common
