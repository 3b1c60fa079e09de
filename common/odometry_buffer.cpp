// SPDX-License-Identifier: BSD-3-Clause
#include "common/odometry_buffer.hpp"

#include <algorithm>

namespace slamfuse::common {
namespace {

/// The body twist [m/s, m/s, rad/s] at the newest message: as told, or from the last two poses where the source tells
/// none.
Eigen::Vector3d newest_twist(const std::deque<WheelOdometry>& messages) {
  const WheelOdometry& newest = messages.back();
  if (newest.forward_speed != 0.0 || newest.turn_rate != 0.0 || messages.size() < 2) {
    return {newest.forward_speed, 0.0, newest.turn_rate};
  }
  const WheelOdometry& previous = messages[messages.size() - 2];
  return log_se2(previous.pose.inverse() * newest.pose) / to_seconds(newest.stamp - previous.stamp);
}

}  // namespace

OdometryBuffer::OdometryBuffer(Nanoseconds memory, Nanoseconds max_extrapolation)
    : memory_(memory), max_extrapolation_(max_extrapolation) {}

void OdometryBuffer::add(const WheelOdometry& odometry) {
  while (!messages_.empty() && messages_.back().stamp >= odometry.stamp) messages_.pop_back();
  messages_.push_back(odometry);
  while (messages_.front().stamp < odometry.stamp - memory_) messages_.pop_front();
}

std::optional<Pose2> OdometryBuffer::pose_at(Nanoseconds stamp) const {
  const auto after = std::lower_bound(messages_.begin(), messages_.end(), stamp,
                                      [](const WheelOdometry& m, Nanoseconds t) { return m.stamp < t; });
  if (after == messages_.end()) {
    if (messages_.empty() || stamp - messages_.back().stamp > max_extrapolation_) return std::nullopt;
    return messages_.back().pose * exp_se2(newest_twist(messages_) * to_seconds(stamp - messages_.back().stamp));
  }
  if (after->stamp == stamp) return after->pose;
  if (after == messages_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double fraction =
      static_cast<double>(stamp - before->stamp) / static_cast<double>(after->stamp - before->stamp);
  return before->pose * exp_se2(log_se2(before->pose.inverse() * after->pose) * fraction);
}

}  // namespace slamfuse::common
