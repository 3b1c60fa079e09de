// SPDX-License-Identifier: BSD-3-Clause
#include "service/input_diagnostics.hpp"

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "service/ros_conversion.hpp"

namespace slamfuse::service {
namespace {

using Seconds = std::chrono::duration<double>;

/// A topic is silent after so many of its usual periods, but not sooner than after a second [s].
constexpr double kSilentPeriods = 5.0;
constexpr double kSoonestSilent = 1.0;

/// Whether messages are due all the time: not of transforms and calibrations.
bool is_steady(const InputState& input) { return !input.sensor.empty() && !is_calibration(input); }

/// Whether a message has to come at least once: of sensors.
bool is_due(const InputState& input, std::optional<double> age) {
  return is_steady(input) || (is_calibration(input) && !age && input.required);
}

std::optional<double> age_of(const InputState& input, InputDiagnostics::Time now) {
  if (!input.last_arrival) return std::nullopt;
  return Seconds(now - *input.last_arrival).count();
}

/// What is wrong, the worst first; `before` is the last look.
std::pair<DiagnosisLevel, std::string> verdict_on(const InputState& input, const InputState& before,
                                                  const RateWatch& rate, std::optional<double> age) {
  if (input.writers == 0 && !input.incompatible_qos.empty()) {
    return {DiagnosisLevel::kError,
            fmt::format("QoS mismatch: the publisher's {} is not enough for this reader", input.incompatible_qos)};
  }
  if (!input.other_type.empty()) {
    return {DiagnosisLevel::kError,
            fmt::format("type mismatch: {} is published, expected is {}", input.other_type, input.type)};
  }
  if (input.writers == 0 && is_due(input, age)) {
    if (!age) return {DiagnosisLevel::kError, "nobody publishes it"};
    return {DiagnosisLevel::kError, fmt::format("its publisher has gone, the last message is {:.1f} s old", *age)};
  }
  const double patience = std::max(kSoonestSilent, rate.rate() > 0.0 ? kSilentPeriods / rate.rate() : 0.0);
  if (is_due(input, age) && !age) return {DiagnosisLevel::kError, "matched, but silent from the beginning"};
  if (is_steady(input) && *age > patience) {
    return {DiagnosisLevel::kError, fmt::format("matched, but silent for {:.1f} s", *age)};
  }
  if (!input.in_use && !input.problem.empty()) {
    return {DiagnosisLevel::kError, "cannot be used: " + input.problem};
  }
  if (input.rejected > before.rejected) {
    return {DiagnosisLevel::kWarning,
            fmt::format("{} messages rejected: {}", input.rejected - before.rejected, input.last_rejection)};
  }
  if (input.dropped > before.dropped) {
    return {DiagnosisLevel::kWarning,
            fmt::format("{} messages dropped: they come faster than they are used", input.dropped - before.dropped)};
  }
  if (input.lost > before.lost) {
    return {DiagnosisLevel::kWarning, fmt::format("{} messages lost on the way", input.lost - before.lost)};
  }
  if (const auto unusual = is_steady(input) ? rate.unusual() : std::nullopt) {
    return {DiagnosisLevel::kWarning,
            fmt::format("{:.1f} messages a second, usual are {:.1f}", *unusual, *rate.usual())};
  }
  if (!input.problem.empty()) return {DiagnosisLevel::kWarning, input.problem};
  return {DiagnosisLevel::kOk, "ok"};
}

}  // namespace

std::string to_string(Direction direction) { return direction == Direction::kInput ? "input" : "output"; }

std::vector<Diagnosis> InputDiagnostics::look(const std::vector<InputState>& inputs, Time now) {
  std::vector<Diagnosis> diagnoses;
  for (const InputState& input : inputs) {
    const bool new_topic = !seen_.contains(input.topic);
    Seen& seen = seen_[input.topic];
    const InputState before = new_topic ? input : seen.state;
    if (input.writers == 0) seen.rate.reset();
    seen.rate.look(now, input.received);
    seen.state = input;
    const bool heard = input.received > 0 || !input.incompatible_qos.empty() || !input.other_type.empty();
    // Of a picture's raw and compressed topics one is enough: the other one has nothing to say.
    if (!heard && !input.required && (!input.in_use || input.writers == 0)) continue;

    const auto age = age_of(input, now);
    Diagnosis diagnosis{input.topic, DiagnosisLevel::kOk, {}, {}, Direction::kInput};
    std::tie(diagnosis.level, diagnosis.message) = verdict_on(input, before, seen.rate, age);
    diagnosis.values = {{"sensor", input.sensor},
                        {"type", input.type},
                        {"in use", input.in_use ? "yes" : "no"},
                        {"publishers", std::to_string(input.writers)},
                        {"rate [Hz]", fmt::format("{:.2f}", seen.rate.rate())},
                        {"age [s]", age ? fmt::format("{:.3f}", *age) : std::string("never heard")},
                        {"received", std::to_string(input.received)},
                        {"rejected", std::to_string(input.rejected)},
                        {"dropped", std::to_string(input.dropped)},
                        {"lost", std::to_string(input.lost)}};
    if (input.clock_offset) {
      diagnosis.values.emplace_back("clock minus stamp [s]",
                                    fmt::format("{:.3f}", common::to_seconds(*input.clock_offset)));
    }
    if (!input.last_rejection.empty()) diagnosis.values.emplace_back("last rejection", input.last_rejection);
    diagnoses.push_back(std::move(diagnosis));
  }
  return diagnoses;
}

idl::Message<idl::DiagnosticArray> to_ros_diagnostics(common::Nanoseconds stamp, const std::string& node,
                                                      const std::vector<Diagnosis>& diagnoses) {
  idl::Message<idl::DiagnosticArray> message;
  message->header.stamp = to_ros_time(stamp);
  idl::assign(message->header.frame_id, "");
  idl::allocate(message->status, diagnoses.size());
  for (std::size_t i = 0; i < diagnoses.size(); ++i) {
    const Diagnosis& diagnosis = diagnoses[i];
    idl::DiagnosticStatus& status = message->status._buffer[i];
    status.level = static_cast<std::uint8_t>(diagnosis.level);
    idl::assign(status.name, node + ": " + to_string(diagnosis.direction) + " " + diagnosis.topic);
    idl::assign(status.message, diagnosis.message);
    idl::assign(status.hardware_id, node);
    idl::allocate(status.values, diagnosis.values.size());
    for (std::size_t k = 0; k < diagnosis.values.size(); ++k) {
      idl::assign(status.values._buffer[k].key, diagnosis.values[k].first);
      idl::assign(status.values._buffer[k].value, diagnosis.values[k].second);
    }
  }
  return message;
}

}  // namespace slamfuse::service
