// SPDX-License-Identifier: BSD-3-Clause
#include "benchmark/faulty_recording.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <variant>

namespace slamfuse {
namespace {

using common::Nanoseconds;
using common::RecordingItem;
using common::SensorMessage;

void set_stamp(SensorMessage& message, Nanoseconds stamp) {
  std::visit([stamp](auto& m) { m.stamp = stamp; }, message);
}

/// The beams of `scan` that point where the beams of a laser of another geometry would.
std::vector<float> resampled(const std::vector<float>& ranges, const common::LaserCalibration& from,
                             const common::LaserCalibration& to) {
  std::vector<float> result;
  for (int beam = 0; beam < to.beams; ++beam) {
    const double bearing = to.angle_min + beam * to.angle_increment;
    const double nearest = std::round((bearing - from.angle_min) / from.angle_increment);
    const double last = static_cast<double>(ranges.size()) - 1.0;
    result.push_back(ranges[static_cast<std::size_t>(std::clamp(nearest, 0.0, last))]);
  }
  return result;
}

class FaultyRecording : public common::Recording {
 public:
  FaultyRecording(std::unique_ptr<common::Recording> recording, SensorFault fault,
                  std::unique_ptr<common::Recording> donor)
      : recording_(std::move(recording)), fault_(std::move(fault)), donor_(std::move(donor)) {}

  const common::RecordingInfo& info() const override { return recording_->info(); }

  common::Result<std::optional<RecordingItem>> next() override {
    while (true) {
      auto item = recording_->next();
      if (!item || !*item) return item;
      auto* message = std::get_if<SensorMessage>(&**item);
      if (message == nullptr || !concerns(common::sensor_of(*message))) return item;
      const Nanoseconds stamp = common::stamp_of(*message);
      const double time = common::to_seconds(stamp - info().first_stamp);
      if (time < fault_.from || time >= fault_.to) {
        last_good_[common::sensor_of(*message)] = *message;
        return item;
      }
      if (fault_.kind == FaultKind::kSilenced) continue;
      auto instead = fault_.kind == FaultKind::kFrozen ? last_good(*message) : of_donor(*message);
      if (!instead) continue;
      set_stamp(*instead, stamp);
      return RecordingItem(std::move(*instead));
    }
  }

 private:
  bool concerns(const std::string& sensor) const {
    return std::any_of(fault_.sensors.begin(), fault_.sensors.end(),
                       [&](const std::string& beginning) { return sensor.starts_with(beginning); });
  }

  std::optional<SensorMessage> last_good(const SensorMessage& message) const {
    const auto found = last_good_.find(common::sensor_of(message));
    return found == last_good_.end() ? std::nullopt : std::optional(found->second);
  }

  std::optional<SensorMessage> of_donor(const SensorMessage& message) {
    const Nanoseconds time = common::stamp_of(message) - info().first_stamp;
    while (donated_until_ <= time) {
      auto item = donor_->next();
      if (!item || !*item) break;
      if (auto* other = std::get_if<SensorMessage>(&**item)) {
        donated_until_ = common::stamp_of(*other) - donor_->info().first_stamp;
        donated_[common::sensor_of(*other)] = *other;
      }
    }
    const std::string& sensor = common::sensor_of(message);
    const bool same_name = donated_.contains(sensor);
    const auto found = donated_.find(same_name || sensor.starts_with("laser") ? sensor : "cam0");
    if (found == donated_.end()) return std::nullopt;
    SensorMessage result = found->second;
    std::visit([&](auto& m) { m.sensor = sensor; }, result);
    if (auto* scan = std::get_if<common::LaserScan>(&result)) {
      scan->ranges =
          resampled(scan->ranges, donor_->info().calibration.lasers.at(sensor), info().calibration.lasers.at(sensor));
    }
    return result;
  }

  std::unique_ptr<common::Recording> recording_;
  SensorFault fault_;
  std::unique_ptr<common::Recording> donor_;
  std::map<std::string, SensorMessage> last_good_;
  std::map<std::string, SensorMessage> donated_;  // the newest of each sensor
  Nanoseconds donated_until_ = -1;
};

class ShortenedRecording : public common::Recording {
 public:
  ShortenedRecording(std::unique_ptr<common::Recording> recording, double from, double to)
      : recording_(std::move(recording)),
        from_(recording_->info().first_stamp + common::from_seconds(from)),
        to_(recording_->info().first_stamp + common::from_seconds(to)) {}

  const common::RecordingInfo& info() const override { return recording_->info(); }

  common::Result<std::optional<RecordingItem>> next() override {
    while (true) {
      auto item = recording_->next();
      if (!item || !*item) return item;
      auto* message = std::get_if<SensorMessage>(&**item);
      if (message == nullptr) continue;
      const Nanoseconds stamp = common::stamp_of(*message);
      if (stamp >= from_ && stamp < to_) continue;
      if (stamp >= to_) set_stamp(*message, stamp - (to_ - from_));
      return item;
    }
  }

 private:
  std::unique_ptr<common::Recording> recording_;
  Nanoseconds from_;
  Nanoseconds to_;
};

}  // namespace

std::string to_string(FaultKind kind) {
  switch (kind) {
    case FaultKind::kSilenced:
      return "silenced";
    case FaultKind::kFrozen:
      return "frozen";
    case FaultKind::kReplaced:
      break;
  }
  return "of another recording";
}

std::unique_ptr<common::Recording> with_fault(std::unique_ptr<common::Recording> recording, SensorFault fault,
                                              std::unique_ptr<common::Recording> donor) {
  return std::make_unique<FaultyRecording>(std::move(recording), std::move(fault), std::move(donor));
}

std::unique_ptr<common::Recording> without_time(std::unique_ptr<common::Recording> recording, double from, double to) {
  return std::make_unique<ShortenedRecording>(std::move(recording), from, to);
}

}  // namespace slamfuse
