// SPDX-License-Identifier: BSD-3-Clause
#include "common/recording_span.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace slamfuse::common {

Result<void> set_time_span(RecordingInfo& info) {
  using NamedSensor = std::pair<const std::string, SensorInfo>;
  const NamedSensor* latest_start = nullptr;
  const NamedSensor* earliest_end = nullptr;
  for (const NamedSensor& named : info.sensors) {
    const SensorInfo& sensor = named.second;
    if (sensor.messages == 0) continue;
    if (latest_start == nullptr) {
      info.first_stamp = sensor.first_stamp;
      info.last_stamp = sensor.last_stamp;
      latest_start = earliest_end = &named;
    }
    info.first_stamp = std::min(info.first_stamp, sensor.first_stamp);
    info.last_stamp = std::max(info.last_stamp, sensor.last_stamp);
    if (sensor.first_stamp > latest_start->second.first_stamp) latest_start = &named;
    if (sensor.last_stamp < earliest_end->second.last_stamp) earliest_end = &named;
  }
  if (latest_start == nullptr) {
    return invalid_input(info.path.string() + ": empty recording, no sensor has a usable message");
  }
  if (latest_start->second.first_stamp > earliest_end->second.last_stamp) {
    return invalid_input(info.path.string() + ": sensors have no time in common: " + latest_start->first +
                         " starts at " + format_seconds(latest_start->second.first_stamp) + " s, " +
                         earliest_end->first + " ends at " + format_seconds(earliest_end->second.last_stamp) + " s");
  }
  return {};
}

}  // namespace slamfuse::common
