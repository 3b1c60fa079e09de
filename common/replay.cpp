// SPDX-License-Identifier: BSD-3-Clause
#include "common/replay.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "common/angle.hpp"

namespace slamfuse::common {
namespace {

constexpr double kLongestDelay = 60.0;     ///< [s] bounds the memory
constexpr double kLargestOffset = 3600.0;  ///< [s]
constexpr double kLongestSweep = 60.0;     ///< [s]
constexpr double kLongestRecording = 1e9;  ///< [s]
constexpr Nanoseconds kOutOfStep = 5 * kNanosecondsPerSecond;

Nanoseconds stamp_of(const RecordingItem& item) {
  const auto* rejected = std::get_if<RejectedMessage>(&item);
  return rejected != nullptr ? rejected->stamp : stamp_of(std::get<SensorMessage>(item));
}

const std::string& sensor_of(const RecordingItem& item) {
  const auto* rejected = std::get_if<RejectedMessage>(&item);
  return rejected != nullptr ? rejected->sensor : sensor_of(std::get<SensorMessage>(item));
}

void move_stamp(RecordingItem& item, Nanoseconds offset) {
  if (auto* rejected = std::get_if<RejectedMessage>(&item)) {
    rejected->stamp += offset;
  } else {
    std::visit([offset](auto& message) { message.stamp += offset; }, std::get<SensorMessage>(item));
  }
}

void reverse_beams(RecordingItem& item) {
  auto* message = std::get_if<SensorMessage>(&item);
  auto* scan = message != nullptr ? std::get_if<LaserScan>(message) : nullptr;
  if (scan != nullptr) std::reverse(scan->ranges.begin(), scan->ranges.end());
}

using BySensor = std::map<std::string, Nanoseconds>;

Nanoseconds value_or_zero(const BySensor& values, const std::string& sensor) {
  const auto found = values.find(sensor);
  return found == values.end() ? 0 : found->second;
}

class Replay final : public Recording {
 public:
  Replay(std::unique_ptr<Recording> source, RecordingInfo info, Nanoseconds begin, Nanoseconds end,
         std::set<std::string> only_sensors, std::set<std::string> reversed, BySensor delays, BySensor offsets)
      : source_(std::move(source)),
        info_(std::move(info)),
        begin_(begin),
        end_(end),
        only_sensors_(std::move(only_sensors)),
        reversed_(std::move(reversed)),
        delays_(std::move(delays)),
        offsets_(std::move(offsets)) {}

  const RecordingInfo& info() const override { return info_; }

  Result<std::optional<RecordingItem>> next() override {
    // All that is still to come arrives at the source's clock or later.
    while (!source_ended_ && (waiting_.empty() || waiting_.front().arrival > clock_)) {
      const Result<void> fetched = fetch();
      if (!fetched) return tl::unexpected(fetched.error());
    }
    if (waiting_.empty()) return std::nullopt;
    std::pop_heap(waiting_.begin(), waiting_.end(), comes_later);
    RecordingItem item = std::move(waiting_.back().item);
    waiting_.pop_back();
    move_stamp(item, value_or_zero(offsets_, sensor_of(item)));
    if (reversed_.contains(sensor_of(item))) reverse_beams(item);
    return item;
  }

 private:
  struct Waiting {
    Nanoseconds arrival = 0;
    std::uint64_t index = 0;  ///< in the original order
    RecordingItem item;
  };

  static bool comes_later(const Waiting& a, const Waiting& b) {
    return std::tie(a.arrival, a.index) > std::tie(b.arrival, b.index);
  }

  Result<void> fetch() {
    Result<std::optional<RecordingItem>> item = source_->next();
    if (!item) return tl::unexpected(item.error());
    source_ended_ = !*item;
    if (source_ended_) return {};
    const Nanoseconds stamp = stamp_of(**item);
    clock_ = std::max(clock_, stamp);
    if (stamp < begin_ || stamp > end_) {
      // Behind the end nothing more can come, unless stamps step back; sensors in one file may be a little out of step.
      source_ended_ = info_.stamp_ordered && stamp > end_ + kOutOfStep;
      return {};
    }
    if (!only_sensors_.empty() && !only_sensors_.contains(sensor_of(**item))) return {};
    const Nanoseconds arrival = clock_ + value_or_zero(delays_, sensor_of(**item));
    waiting_.push_back({arrival, next_index_++, std::move(**item)});
    std::push_heap(waiting_.begin(), waiting_.end(), comes_later);
    return {};
  }

  std::unique_ptr<Recording> source_;
  RecordingInfo info_;
  Nanoseconds begin_;
  Nanoseconds end_;
  std::set<std::string> only_sensors_;
  std::set<std::string> reversed_;  ///< lasers whose last beam is fired first
  BySensor delays_;
  BySensor offsets_;
  std::vector<Waiting> waiting_;                                 ///< a heap, the first to arrive at its front
  Nanoseconds clock_ = std::numeric_limits<Nanoseconds>::min();  ///< largest true stamp fetched
  std::uint64_t next_index_ = 0;
  bool source_ended_ = false;
};

Result<BySensor> checked(const std::map<std::string, double>& seconds, const RecordingInfo& info,
                         const std::string& option, double min, double max) {
  BySensor result;
  for (const auto& [sensor, value] : seconds) {
    if (!info.sensors.contains(sensor)) {
      std::string known;
      for (const auto& named : info.sensors) known += (known.empty() ? "" : ", ") + named.first;
      return usage_error(option + " names the sensor " + sensor + ", which " + info.path.string() +
                         " does not have (it has: " + known + ")");
    }
    if (!(value >= min && value <= max)) {
      return usage_error(option + " of " + sensor + " is " + std::to_string(value) +
                         " s (allowed: " + std::to_string(min) + " to " + std::to_string(max) + ")");
    }
    result[sensor] = from_seconds(value);
  }
  return result;
}

RecordingInfo played_info(RecordingInfo info, Nanoseconds begin, Nanoseconds end, const BySensor& offsets) {
  info.first_stamp = std::numeric_limits<Nanoseconds>::max();
  info.last_stamp = std::numeric_limits<Nanoseconds>::min();
  for (auto& [name, sensor] : info.sensors) {
    if (sensor.messages == 0) continue;
    const Nanoseconds offset = value_or_zero(offsets, name);
    sensor.first_stamp = std::max(sensor.first_stamp, begin) + offset;
    sensor.last_stamp = std::min(sensor.last_stamp, end) + offset;
    info.first_stamp = std::min(info.first_stamp, sensor.first_stamp);
    info.last_stamp = std::max(info.last_stamp, sensor.last_stamp);
  }
  return info;
}

/// Sets the sweep durations of lasers; those with a negative one are turned round and named in `reversed`.
Result<void> set_sweeps(const BySensor& sweeps, RecordingInfo& info, std::set<std::string>& reversed) {
  for (const auto& [sensor, sweep] : sweeps) {
    const auto found = info.calibration.lasers.find(sensor);
    if (found == info.calibration.lasers.end()) return usage_error("--sweep-duration: " + sensor + " is no laser");
    LaserCalibration& laser = found->second;
    laser.sweep_duration = std::abs(to_seconds(sweep));
    if (sweep >= 0) continue;
    if (laser.beams == 0) {
      return usage_error("--sweep-duration of " + sensor +
                         " is negative, but its scans vary in length, so their last beam is not known");
    }
    // Of a full turn that begins at 180 deg the last beam would stand at 540.
    laser.angle_min = normalize_angle(laser.angle_min + (laser.beams - 1) * laser.angle_increment);
    laser.angle_increment = -laser.angle_increment;
    reversed.insert(sensor);
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<Recording>> replay(std::unique_ptr<Recording> recording, const ReplayOptions& options) {
  const RecordingInfo& info = recording->info();
  const double to = options.to.value_or(kLongestRecording);
  if (!(options.from >= 0.0 && options.from < to && to <= kLongestRecording)) {
    return usage_error("--from " + std::to_string(options.from) + " --to " + std::to_string(to) +
                       " (allowed: 0 <= from < to, in seconds)");
  }
  Result<BySensor> delays = checked(options.arrival_delay, info, "--arrival-delay", 0.0, kLongestDelay);
  if (!delays) return tl::unexpected(delays.error());
  Result<BySensor> offsets = checked(options.stamp_offset, info, "--stamp-offset", -kLargestOffset, kLargestOffset);
  if (!offsets) return tl::unexpected(offsets.error());
  Result<BySensor> sweeps = checked(options.sweep_duration, info, "--sweep-duration", -kLongestSweep, kLongestSweep);
  if (!sweeps) return tl::unexpected(sweeps.error());

  const Nanoseconds begin = info.first_stamp + from_seconds(options.from);
  const Nanoseconds end = info.first_stamp + from_seconds(to);
  if (begin > info.last_stamp) {
    return usage_error("--from " + std::to_string(options.from) + " is behind the end of " + info.path.string() +
                       ", which lasts " + std::to_string(to_seconds(info.last_stamp - info.first_stamp)) + " s");
  }
  RecordingInfo played = played_info(info, begin, end, *offsets);
  std::set<std::string> reversed;
  if (auto set = set_sweeps(*sweeps, played, reversed); !set) return tl::unexpected(set.error());
  return std::make_unique<Replay>(std::move(recording), std::move(played), begin, end, options.only_sensors,
                                  std::move(reversed), std::move(*delays), std::move(*offsets));
}

}  // namespace slamfuse::common
