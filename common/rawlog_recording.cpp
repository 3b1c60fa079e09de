// SPDX-License-Identifier: BSD-3-Clause
#include "common/rawlog_recording.hpp"

#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/CSerializable.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/angle.hpp"
#include "common/byte_source.hpp"
#include "common/laser_reading.hpp"
#include "common/recording_span.hpp"

namespace slamfuse::common {
namespace {

constexpr const char* kOdometryName = "odom0";
constexpr std::size_t kMostReadings = 100'000;
/// Geometry repeated with every scan may differ by rounding, not by more [m, rad].
constexpr double kGeometryTolerance = 1e-4;

/// What MRPT reads objects from: our decompressed bytes. Knows whether the data ended between two objects.
class SourceArchive final : public mrpt::serialization::CArchive {
 public:
  explicit SourceArchive(std::unique_ptr<ByteSource> source) : source_(std::move(source)) {}

  /// The next object; empty when the data ends just before one. Throws what MRPT throws, and on damaged data.
  mrpt::serialization::CSerializable::Ptr read_object() {
    object_begun_ = false;
    ended_between_objects_ = false;
    try {
      return ReadObject();
    } catch (const std::exception&) {
      if (ended_between_objects_) return nullptr;
      throw;
    }
  }

  /// Why the data ended in the middle of an object; empty when it did not.
  const std::string& failure() const { return failure_; }

  std::string getArchiveDescription() const override { return "rawlog"; }

 protected:
  size_t read(void* buffer, size_t length) override {
    const std::span<char> wanted(static_cast<char*>(buffer), length);
    std::size_t size = 0;
    while (size < length) {
      if (begin_ == end_) fill();
      if (begin_ == end_) {
        ended_between_objects_ = !object_begun_ && size == 0;
        fail("the file ends in the middle of an entry");
      }
      const std::size_t count = std::min(length - size, end_ - begin_);
      std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_), count,
                  wanted.begin() + static_cast<std::ptrdiff_t>(size));
      begin_ += count;
      size += count;
    }
    object_begun_ = true;
    return size;
  }

  size_t write(const void*, size_t) override { throw std::logic_error("a rawlog is only read"); }

 private:
  void fill() {
    const Result<std::size_t> count = source_->read(buffer_);
    if (!count) {
      object_begun_ = true;  // damaged, even if between two objects
      fail(count.error().message);
    }
    begin_ = 0;
    end_ = *count;
  }

  /// Keeps the reason, because MRPT throws another exception on the way up.
  [[noreturn]] void fail(const std::string& reason) {
    failure_ = reason;
    throw std::runtime_error(reason);
  }

  std::unique_ptr<ByteSource> source_;
  std::string failure_;
  std::vector<char> buffer_ = std::vector<char>(1U << 16);
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  bool object_begun_ = false;
  bool ended_between_objects_ = false;
};

/// MRPT counts 100 ns since 1601; 0 stands for no stamp, which becomes a negative number here.
Nanoseconds stamp_from(const mrpt::Clock::time_point& time) {
  constexpr std::int64_t kTicksFrom1601To1970 = 116'444'736'000'000'000;
  constexpr std::int64_t kLatestTicks = kTicksFrom1601To1970 + 40'000'000'000'000'000;  // the year 2096
  constexpr std::int64_t kNanosecondsPerTick = 100;
  const std::int64_t ticks = time.time_since_epoch().count();
  if (ticks < kTicksFrom1601To1970 || ticks > kLatestTicks) return -1;
  return (ticks - kTicksFrom1601To1970) * kNanosecondsPerTick;
}

Pose2 pose_from(const mrpt::poses::CPose2D& pose) { return {pose.x(), pose.y(), normalize_angle(pose.phi())}; }

Pose3 pose_from(const mrpt::poses::CPose3D& pose) {
  const Eigen::Matrix3d rotation = pose.getRotationMatrix().asEigen();
  return {{pose.x(), pose.y(), pose.z()}, Eigen::Quaterniond(rotation).normalized()};
}

/// Ranges run with the bearing here whichever way the laser turns; the sweep's duration is not in a rawlog.
LaserCalibration calibration_from(const mrpt::obs::CObservation2DRangeScan& scan) {
  LaserCalibration laser;
  laser.T_base_laser = pose_from(scan.sensorPose);
  laser.beams = static_cast<int>(scan.getScanSize());
  laser.angle_min = -0.5 * double{scan.aperture};
  laser.angle_increment = double{scan.aperture} / (laser.beams - 1);
  laser.range_max = double{scan.maxRange};
  return laser;
}

bool same_geometry(const LaserCalibration& a, const LaserCalibration& b) {
  const Pose3 change = a.T_base_laser.inverse() * b.T_base_laser;
  return a.beams == b.beams && std::abs(a.angle_min - b.angle_min) < kGeometryTolerance &&
         std::abs(a.range_max - b.range_max) < kGeometryTolerance && change.translation.norm() < kGeometryTolerance &&
         change.rotation.vec().norm() < kGeometryTolerance;
}

/// What an exception says, without the place in MRPT's sources and the call stack that MRPT adds.
std::string told_by(const std::exception& error) {
  const std::string_view text = error.what();
  constexpr std::string_view kLabel = "Message:";
  const std::size_t label = text.find(kLabel);
  const std::size_t begin = label == std::string_view::npos ? 0 : text.find_first_not_of(' ', label + kLabel.size());
  return std::string(text.substr(std::min(begin, text.size()), text.find('\n', begin) - begin));
}

/// The entries of a rawlog as messages, front to back.
class RawlogReader {
 public:
  /// `odometry_from_actions`: whether sensory frames get the odometry integrated from the actions before them.
  RawlogReader(std::unique_ptr<ByteSource> source, std::string file, bool odometry_from_actions)
      : archive_(std::move(source)), file_(std::move(file)), odometry_from_actions_(odometry_from_actions) {}

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
    try {
      const mrpt::serialization::CSerializable::Ptr object = archive_.read_object();
      ended_ = object == nullptr;
      if (ended_) return;
      ++entry_;
      if (const auto actions = std::dynamic_pointer_cast<mrpt::obs::CActionCollection>(object)) {
        integrate(*actions);
      } else if (const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object)) {
        add_frame(*frame);
      } else if (const auto observation = std::dynamic_pointer_cast<mrpt::obs::CObservation>(object)) {
        add_observation(*observation, 0);
      }
    } catch (const std::exception& error) {
      ended_ = true;
      reject(last_sensor_, last_stamp_,
             "damaged, cut short or of a kind MRPT does not know, nothing behind it can be read: " +
                 (archive_.failure().empty() ? told_by(error) : archive_.failure()));
    }
  }

  void integrate(const mrpt::obs::CActionCollection& actions) {
    mrpt::obs::CActionRobotMovement2D::Ptr movement =
        const_cast<mrpt::obs::CActionCollection&>(actions).getMovementEstimationByType(
            mrpt::obs::CActionRobotMovement2D::emOdometry);
    if (!movement) return;
    saw_actions_ = true;
    const Pose2 step = pose_from(movement->rawOdometryIncrementReading);
    if (!step.is_finite()) return reject(kOdometryName, last_stamp_, "odometry step that is not finite");
    odometry_ = odometry_ * step;
    forward_speed_ = movement->hasVelocities ? movement->velocityLin() : 0.0;
    turn_rate_ = movement->hasVelocities ? movement->velocityAng() : 0.0;
  }

  /// The odometry of an action/observation rawlog has no stamp: it is that of the frame's first scan.
  void add_frame(const mrpt::obs::CSensoryFrame& frame) {
    std::size_t unlabelled = 0;
    bool first = true;
    for (const mrpt::obs::CObservation::Ptr& observation : frame) {
      if (!observation) continue;
      const bool is_scan = dynamic_cast<const mrpt::obs::CObservation2DRangeScan*>(observation.get()) != nullptr;
      if (is_scan && first && odometry_from_actions_) {
        first = false;
        add({stamp_from(observation->timestamp), kOdometryName, odometry_, forward_speed_, turn_rate_});
      }
      add_observation(*observation, unlabelled);
      if (is_scan && observation->sensorLabel.empty()) ++unlabelled;
    }
  }

  /// `unlabelled`: how many scans without a label came before in the same frame; they are told apart by their order.
  void add_observation(const mrpt::obs::CObservation& observation, std::size_t unlabelled) {
    if (const auto* scan = dynamic_cast<const mrpt::obs::CObservation2DRangeScan*>(&observation)) {
      add_scan(*scan, scan->sensorLabel.empty() ? std::to_string(unlabelled) : "label " + scan->sensorLabel);
    } else if (const auto* odometry = dynamic_cast<const mrpt::obs::CObservationOdometry*>(&observation)) {
      const double speed = odometry->hasVelocities ? odometry->velocityLocal.vx : 0.0;
      const double rate = odometry->hasVelocities ? odometry->velocityLocal.omega : 0.0;
      add({stamp_from(odometry->timestamp), kOdometryName, pose_from(odometry->odometry), speed, rate});
    }
  }

  void add(WheelOdometry odometry) {
    if (!accept_stamp(kOdometryName, odometry.stamp)) return;
    if (!odometry.pose.is_finite() || !std::isfinite(odometry.forward_speed) || !std::isfinite(odometry.turn_rate)) {
      return reject(kOdometryName, odometry.stamp, "odometry that is not finite");
    }
    ready_.emplace_back(SensorMessage(std::move(odometry)));
  }

  void add_scan(const mrpt::obs::CObservation2DRangeScan& scan, const std::string& label) {
    const auto [named, is_new] = names_.try_emplace(label, "laser" + std::to_string(names_.size()));
    const std::string& name = named->second;
    const Nanoseconds stamp = stamp_from(scan.timestamp);
    if (!accept_stamp(name, stamp)) return;
    const std::size_t beams = scan.getScanSize();
    if (beams < 2 || beams > kMostReadings) {
      return reject(
          name, stamp,
          "scan of " + std::to_string(beams) + " readings (allowed: 2 to " + std::to_string(kMostReadings) + ")");
    }
    const LaserCalibration geometry = calibration_from(scan);
    constexpr double kFullTurn = 2.0 * std::numbers::pi * (1.0 + kGeometryTolerance);
    if (!(geometry.angle_increment > 0.0 && -2.0 * geometry.angle_min <= kFullTurn && geometry.range_max > 0.0 &&
          std::isfinite(geometry.range_max) && geometry.T_base_laser.is_finite())) {
      return reject(name, stamp, "scan with an impossible aperture, maximum range or mounting");
    }
    const LaserCalibration& laser = lasers_.try_emplace(name, geometry).first->second;
    if (!same_geometry(laser, geometry)) {
      return reject(name, stamp,
                    "scan with another number of readings, aperture, maximum range or mounting than the first");
    }

    LaserScan message{stamp, name, {}};
    message.ranges.reserve(beams);
    for (std::size_t i = 0; i < beams; ++i) {
      const std::size_t at = scan.rightToLeft ? i : beams - 1 - i;
      const double reading = double{scan.getScanRange(at)};
      const bool valid = scan.getScanRangeValidity(at);
      if (valid && (!std::isfinite(reading) || reading < 0.0)) {
        return reject(name, stamp, "valid range " + std::to_string(reading) + " (allowed: finite, 0 and above)");
      }
      if (reading >= laser.range_max) {
        message.ranges.push_back(kBeyondRange);
      } else {
        message.ranges.push_back(valid ? as_range(reading, laser) : kNoMeasurement);
      }
    }
    ready_.emplace_back(SensorMessage(std::move(message)));
  }

  /// Stamps of one sensor rise; a message whose stamp does not is rejected here.
  bool accept_stamp(const std::string& sensor, Nanoseconds stamp) {
    const auto last = last_stamps_.find(sensor);
    if (stamp < 0) {
      reject(sensor, last == last_stamps_.end() ? last_stamp_ : last->second, "no usable stamp");
      return false;
    }
    if (last != last_stamps_.end() && stamp <= last->second) {
      reject(sensor, last->second,
             "stamp " + std::to_string(stamp) + (stamp == last->second ? " repeats" : " steps back") +
                 " (allowed: rising stamps)");
      return false;
    }
    last_stamps_[sensor] = last_stamp_ = stamp;
    last_sensor_ = sensor;
    return true;
  }

  void reject(const std::string& sensor, Nanoseconds stamp, const std::string& problem) {
    ready_.emplace_back(RejectedMessage{stamp, sensor, file_ + ": entry " + std::to_string(entry_) + ": " + problem});
  }

  SourceArchive archive_;
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
  Pose2 odometry_;
  double forward_speed_ = 0.0;
  double turn_rate_ = 0.0;
};

Result<RawlogReader> open_reader(const std::filesystem::path& path, bool odometry_from_actions) {
  Result<std::unique_ptr<ByteSource>> source = open_byte_source(path);
  if (!source) return tl::unexpected(source.error());
  return RawlogReader(std::move(*source), path.string(), odometry_from_actions);
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
