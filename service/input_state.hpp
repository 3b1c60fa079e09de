// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>

#include "common/time.hpp"

namespace slamfuse::service {

/// How a topic fares.
struct InputState {
  std::string sensor;  ///< empty for what belongs to no sensor
  std::string topic;
  std::string type;              ///< "sensor_msgs/msg/LaserScan"
  bool required = false;         ///< named by the user
  bool in_use = false;           ///< by a module
  std::string problem;           ///< what is missing or wrong of its sensor
  int writers = 0;               ///< matched
  std::string incompatible_qos;  ///< the policy that kept a writer from matching; empty: none did
  std::string other_type;        ///< that somebody publishes under this name while nobody publishes `type`
  std::size_t received = 0;
  std::size_t rejected = 0;
  std::size_t dropped = 0;     ///< the queue was full
  std::size_t lost = 0;        ///< never arrived, as the transport knows
  std::string last_rejection;  ///< why
  std::optional<common::Nanoseconds> last_stamp;
  std::optional<std::chrono::steady_clock::time_point> last_arrival;
  std::optional<common::Nanoseconds> clock_offset;  ///< clock at arrival minus stamp, of the last message
};

/// Whether a topic tells how a camera is built, which it may do once or all the time.
inline bool is_calibration(const InputState& input) { return input.type == "sensor_msgs/msg/CameraInfo"; }

}  // namespace slamfuse::service
