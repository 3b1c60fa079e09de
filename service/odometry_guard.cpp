// SPDX-License-Identifier: BSD-3-Clause
#include "service/odometry_guard.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "common/angle.hpp"

namespace slamfuse::service {
namespace {

/// Stamps are not exact to more than this: so long a step takes at least.
constexpr double kShortestStep = 0.02;
/// So long a sensor has to insist on a new place.
constexpr std::chrono::seconds kPatience{1};

}  // namespace

std::optional<std::string> OdometryGuard::flaw_of(const common::WheelOdometry& odometry, Arrival arrival) {
  if (!(std::abs(odometry.forward_speed) <= limits_.speed)) {
    return fmt::format("the robot drives {:.3g} m/s (allowed: {:g}, service.odometry.speed)", odometry.forward_speed,
                       limits_.speed);
  }
  if (!(std::abs(odometry.turn_rate) <= limits_.turn_rate)) {
    return fmt::format("the robot turns at {:.3g} rad/s (allowed: {:g}, service.odometry.turn_rate)",
                       odometry.turn_rate, limits_.turn_rate);
  }
  Track& track = tracks_[odometry.sensor];
  if (track.last && odometry.stamp <= track.last->stamp) return std::nullopt;
  if (track.last) {
    const auto flaw = flaw_of(*track.last, odometry);
    if (flaw && !insists(track, odometry, arrival)) return flaw;
  }
  track = {odometry, std::nullopt};
  return std::nullopt;
}

std::optional<std::string> OdometryGuard::flaw_of(const common::WheelOdometry& from,
                                                  const common::WheelOdometry& to) const {
  const double seconds = std::max(kShortestStep, common::to_seconds(to.stamp - from.stamp));
  const double distance = (to.pose.translation() - from.pose.translation()).norm();
  if (!(distance <= limits_.speed * seconds)) {
    return fmt::format("odometry jumps by {:.3g} m in {:.3g} s (allowed: {:g} m/s, service.odometry.speed)", distance,
                       seconds, limits_.speed);
  }
  const double turn = std::abs(common::angle_difference(to.pose.theta, from.pose.theta));
  if (!(turn <= limits_.turn_rate * seconds)) {
    return fmt::format("odometry turns by {:.3g} rad in {:.3g} s (allowed: {:g} rad/s, service.odometry.turn_rate)",
                       turn, seconds, limits_.turn_rate);
  }
  return std::nullopt;
}

bool OdometryGuard::insists(Track& track, const common::WheelOdometry& odometry, Arrival arrival) const {
  const bool follows =
      track.refused && odometry.stamp > track.refused->last.stamp && !flaw_of(track.refused->last, odometry);
  if (!follows) {
    track.refused = Refused{arrival, odometry};
    return false;
  }
  track.refused->last = odometry;
  return arrival - track.refused->since >= kPatience;
}

}  // namespace slamfuse::service
