// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "idl/message.hpp"
#include "service/input_state.hpp"
#include "service/rate_watch.hpp"

namespace slamfuse::service {

/// How bad it is, as in diagnostic_msgs/DiagnosticStatus.
enum class DiagnosisLevel : std::uint8_t { kOk = 0, kWarning = 1, kError = 2 };

/// Which way a topic's messages go.
enum class Direction : std::uint8_t { kInput, kOutput };

/// "input" or "output".
std::string to_string(Direction direction);

/// The verdict on one topic.
struct Diagnosis {
  std::string topic;
  DiagnosisLevel level = DiagnosisLevel::kOk;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;  ///< type, rate, age, counters
  Direction direction = Direction::kInput;
};

/// Says of every topic of a live source what is wrong with it, from one look to the next. A topic that nobody
/// named and on which nothing was ever heard is passed over. For one thread at a time.
class InputDiagnostics {
 public:
  using Time = std::chrono::steady_clock::time_point;

  std::vector<Diagnosis> look(const std::vector<InputState>& inputs, Time now);

 private:
  struct Seen {
    InputState state;
    RateWatch rate;
  };
  std::map<std::string, Seen> seen_;  // by topic
};

/// The verdicts of a node as diagnostic_msgs/DiagnosticArray, stamped [ns] by the clock.
idl::Message<idl::DiagnosticArray> to_ros_diagnostics(common::Nanoseconds stamp, const std::string& node,
                                                      const std::vector<Diagnosis>& diagnoses);

}  // namespace slamfuse::service
