// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "common/pose2.hpp"
#include "common/sensor_message.hpp"
#include "common/time.hpp"

namespace slamfuse::common {

/// The recent wheel odometry, asked for the pose at other sensors' stamps.
///
/// A stamp between two messages is interpolated, one just past the newest is extrapolated at the newest speed. A
/// message whose stamp steps back (a CARMEN log in file order) drops what is newer than it, so the latest in arrival
/// order always counts.
///
/// To sum increments without a gap keep the pose a query returned and start the next increment there: an extrapolated
/// pose is not repeated exactly once later messages allow interpolation.
class OdometryBuffer {
 public:
  /// Keeps `memory` of messages and extrapolates at most `max_extrapolation` past the newest.
  explicit OdometryBuffer(Nanoseconds memory = 10 * kNanosecondsPerSecond,
                          Nanoseconds max_extrapolation = kNanosecondsPerSecond / 2);

  void add(const WheelOdometry& odometry);
  bool empty() const { return messages_.empty(); }
  const WheelOdometry& newest() const { return messages_.back(); }

  /// T_odom_base at `stamp`. Returns nothing before the oldest message or too far past the newest.
  std::optional<Pose2> pose_at(Nanoseconds stamp) const;

 private:
  Nanoseconds memory_;
  Nanoseconds max_extrapolation_;
  std::deque<WheelOdometry> messages_;  // stamps strictly increase
};

}  // namespace slamfuse::common
