// SPDX-License-Identifier: BSD-3-Clause
#include "service/rejection_log.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "common/time.hpp"

namespace slamfuse::service {
namespace {

std::string without_figures(const std::string& reason) {
  std::string kind;
  for (const char c : reason) {
    const bool figure = (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+';
    if (!figure) kind += c;
  }
  return kind;
}

}  // namespace

std::optional<common::Event> RejectionLog::add(const common::RejectedMessage& message) {
  std::pair key(message.sensor, without_figures(message.reason));
  if (kinds_.size() >= kMostKinds && !kinds_.contains(key)) key.second.clear();
  Kind& kind = kinds_[key];
  kind.last_stamp = message.stamp;
  if (++kind.count > 1) return std::nullopt;
  kind.first = message;
  return common::Event{message.stamp, "recording", "rejected", message.sensor + ": " + message.reason};
}

std::vector<common::Event> RejectionLog::summary() const {
  std::vector<common::Event> events;
  for (const auto& [key, kind] : kinds_) {
    if (kind.count < 2) continue;
    events.push_back({kind.last_stamp, "recording", "rejected",
                      fmt::format("{}: {} messages like this between {} and {} s, the first: {}", kind.first.sensor,
                                  kind.count, common::format_seconds(kind.first.stamp),
                                  common::format_seconds(kind.last_stamp), kind.first.reason)});
  }
  return events;
}

}  // namespace slamfuse::service
