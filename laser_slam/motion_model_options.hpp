// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"

namespace slamfuse::laser_slam {

/// Settings of the motion model: standard deviations of an increment that moved d metres and turned a radians are
/// sqrt((per_metre d)^2 + (per_radian a)^2 + base^2).
struct MotionModelOptions {
  double translation_per_metre = 0.1;
  double translation_per_radian = 0.05;
  double translation_base = 0.01;
  double rotation_per_metre = 0.1;
  double rotation_per_radian = 0.15;
  double rotation_base = 0.01;
  double max_speed = 3.0;
  double max_turn_rate = 6.0;
  double predicted_acceleration = 2.0;
  double predicted_turn_acceleration = 4.0;

  void describe(common::OptionVisitor& visit) {
    visit.real("translation_per_metre", translation_per_metre, {0.0, 2.0}, "m/m", "Odometry's position error.");
    visit.real("translation_per_radian", translation_per_radian, {0.0, 2.0}, "m/rad",
               "Odometry's position error while turning.");
    visit.real("translation_base", translation_base, {1e-4, 1.0}, "m", "Odometry's position error of any increment.");
    visit.real("rotation_per_metre", rotation_per_metre, {0.0, 2.0}, "rad/m", "Odometry's heading error.");
    visit.real("rotation_per_radian", rotation_per_radian, {0.0, 2.0}, "rad/rad",
               "Odometry's heading error while turning.");
    visit.real("rotation_base", rotation_base, {1e-4, 1.0}, "rad", "Odometry's heading error of any increment.");
    visit.real("max_speed", max_speed, {0.01, 50.0}, "m/s",
               "Faster odometry is checked against standstill and the last speed.");
    visit.real("max_turn_rate", max_turn_rate, {0.01, 50.0}, "rad/s", "The same for turns.");
    visit.real("predicted_acceleration", predicted_acceleration, {0.01, 50.0}, "m/s^2",
               "Without odometry the last speed is kept; this is how much it may change.");
    visit.real("predicted_turn_acceleration", predicted_turn_acceleration, {0.01, 100.0}, "rad/s^2",
               "The same for the turn rate.");
  }
};

}  // namespace slamfuse::laser_slam
