// SPDX-License-Identifier: BSD-3-Clause
#include "system/recording_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include <fmt/format.h>

namespace slamfuse::system {
namespace {

using Messages = std::map<std::string, std::vector<common::SensorMessage>>;

Messages read(common::Recording& recording) {
  Messages messages;
  while (true) {
    auto item = recording.next();
    if (!item || !*item) return messages;
    auto* message = std::get_if<common::SensorMessage>(&**item);
    if (message != nullptr) messages[common::sensor_of(*message)].push_back(std::move(*message));
  }
}

bool same(const common::LaserScan& a, const common::LaserScan& b) {
  return a.stamp == b.stamp && a.ranges.size() == b.ranges.size() &&
         std::equal(a.ranges.begin(), a.ranges.end(), b.ranges.begin(),
                    [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}
bool same(const common::Image& a, const common::Image& b) {
  return a.stamp == b.stamp && a.width == b.width && a.height == b.height && *a.pixels == *b.pixels;
}
bool same(const common::WheelOdometry& a, const common::WheelOdometry& b) {
  // The heading goes through a quaternion.
  constexpr double kRounding = 1e-12;
  return a.stamp == b.stamp && a.pose.x == b.pose.x && a.pose.y == b.pose.y &&
         std::abs(std::remainder(a.pose.theta - b.pose.theta, 2.0 * M_PI)) < kRounding &&
         a.forward_speed == b.forward_speed && a.turn_rate == b.turn_rate;
}
template <class Message>
bool same(const Message& a, const Message& b) {
  return a.stamp == b.stamp;
}

}  // namespace

Comparison compare(common::Recording& expected, common::Recording& actual) {
  Comparison comparison;
  const Messages left = read(expected);
  const Messages right = read(actual);
  for (const auto& [sensor, messages] : left) {
    const auto found = right.find(sensor);
    if (found == right.end()) {
      comparison.difference = sensor + " is missing";
      return comparison;
    }
    if (found->second.size() != messages.size()) {
      comparison.difference = fmt::format("{} has {} messages, not {}", sensor, found->second.size(), messages.size());
      return comparison;
    }
    for (std::size_t i = 0; i < messages.size(); ++i) {
      const bool equal = std::visit(
          [&](const auto& message) {
            const auto* other = std::get_if<std::decay_t<decltype(message)>>(&found->second[i]);
            return other != nullptr && same(message, *other);
          },
          messages[i]);
      if (!equal) {
        comparison.difference =
            fmt::format("{}: message {} of stamp {} is another", sensor, i, common::stamp_of(messages[i]));
        return comparison;
      }
    }
    comparison.same[sensor] = messages.size();
  }
  return comparison;
}

}  // namespace slamfuse::system
