// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>

#include "common/options.hpp"
#include "common/sensor_message.hpp"

namespace slamfuse::service {

/// What a robot cannot do.
struct OdometryLimits {
  double speed = 5.0;
  double turn_rate = 10.0;

  void describe(common::OptionVisitor& visit) {
    visit.real("speed", speed, {0.01, 1000.0}, "m/s",
               "Odometry that says the robot drives faster, or moves so between two messages, is rejected.");
    visit.real("turn_rate", turn_rate, {0.01, 1000.0}, "rad/s", "The same of turning.");
  }
};

/// Judges the wheel odometry of a robot by what its wheels can do: one garbled or forged pose would be taken for a
/// drive. When a sensor's odometry is refused for a second although its messages follow on each other, the robot's
/// driver was started again: then the new place is accepted.
class OdometryGuard {
 public:
  using Arrival = std::chrono::steady_clock::time_point;

  explicit OdometryGuard(const OdometryLimits& limits) : limits_(limits) {}

  /// Why a message that arrived then must not be used; nothing when it may. Stamps that do not rise are for StampGuard
  /// to judge.
  std::optional<std::string> flaw_of(const common::WheelOdometry& odometry, Arrival arrival);
  /// Forgets what the robot did, as after its clock stepped back.
  void reset() { tracks_.clear(); }

 private:
  struct Refused {
    Arrival since;
    common::WheelOdometry last;
  };
  struct Track {
    std::optional<common::WheelOdometry> last;
    std::optional<Refused> refused;
  };

  /// What is impossible about a step.
  std::optional<std::string> flaw_of(const common::WheelOdometry& from, const common::WheelOdometry& to) const;
  /// Whether the sensor insists on a place that was refused.
  bool insists(Track& track, const common::WheelOdometry& odometry, Arrival arrival) const;

  const OdometryLimits limits_;
  std::map<std::string, Track> tracks_;
};

}  // namespace slamfuse::service
