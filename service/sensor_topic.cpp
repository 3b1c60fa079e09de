// SPDX-License-Identifier: BSD-3-Clause
#include "service/sensor_topic.hpp"

namespace slamfuse::service {
namespace {

/// "laser0" counts as the only one: "" ; "laser1": "1"; a name without a number: itself.
std::string number_of(const std::string& sensor) {
  const std::size_t digits = sensor.find_last_not_of("0123456789") + 1;
  const std::string number = sensor.substr(digits);
  if (number.empty()) return "_" + sensor;
  return number == "0" ? std::string() : number;
}

}  // namespace

std::string topic_of(const std::string& sensor, common::SensorKind kind) {
  switch (kind) {
    case common::SensorKind::kLaser:
      return "scan" + number_of(sensor);
    case common::SensorKind::kOdometry:
      return "odom" + number_of(sensor);
    case common::SensorKind::kCamera:
      return sensor + "/image_raw";
    case common::SensorKind::kPose:
      return sensor;
    case common::SensorKind::kImu:
      break;
  }
  return sensor + "/data";
}

}  // namespace slamfuse::service
