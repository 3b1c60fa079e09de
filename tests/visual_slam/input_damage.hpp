// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/calibration.hpp"
#include "common/sensor_message.hpp"
#include "common/time.hpp"

namespace slamfuse::visual_slam::testing {

/// What can go wrong with a robot's camera, and with its wheels.
enum class Damage {
  kNone,
  kBlack,
  kWhite,
  kOverExposed,      ///< most of the picture is saturated
  kBlurred,          ///< out of focus, sigma 8 px
  kCovered,          ///< something dark before the lens: nearly black, with the sensor's noise
  kFrozen,           ///< the last picture again and again, under new stamps
  kDropped,          ///< no pictures
  kOutOfOrder,       ///< every second picture arrives after the one behind it
  kWrongSize,        ///< pictures of half the size
  kWheelSlip,        ///< the wheels turn 20 % more than the robot moves
  kWrongIntrinsics,  ///< the calibration's focal lengths are 10 % too long, from the beginning to the end
};

inline constexpr Damage kAllDamages[] = {Damage::kNone,        Damage::kBlack,     Damage::kWhite,
                                         Damage::kOverExposed, Damage::kBlurred,   Damage::kCovered,
                                         Damage::kFrozen,      Damage::kDropped,   Damage::kOutOfOrder,
                                         Damage::kWrongSize,   Damage::kWheelSlip, Damage::kWrongIntrinsics};

std::string to_string(Damage damage);

/// Damages the messages with stamps in [from, to), in order, and hands on the others; wheel odometry after a slip goes
/// on from where the slip has brought it.
class Damager {
 public:
  Damager(Damage damage, common::Nanoseconds from, common::Nanoseconds to) : damage_(damage), from_(from), to_(to) {}

  /// What arrives instead of the message.
  std::vector<common::SensorMessage> apply(const common::SensorMessage& message);

 private:
  std::vector<common::SensorMessage> damaged(const common::Image& image);
  common::WheelOdometry slipped(const common::WheelOdometry& odometry);

  Damage damage_;
  common::Nanoseconds from_;
  common::Nanoseconds to_;
  std::map<std::string, common::Image> last_;  // good picture of each camera
  std::map<std::string, common::Image> held_;  // to be delivered late
  std::optional<common::Pose2> true_odometry_;
  common::Pose2 slipped_odometry_;
  unsigned pictures_ = 0;
};

/// The calibration as the module gets it.
std::map<std::string, common::CameraCalibration> damaged(Damage damage,
                                                         std::map<std::string, common::CameraCalibration> cameras);

}  // namespace slamfuse::visual_slam::testing
