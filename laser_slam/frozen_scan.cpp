// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/frozen_scan.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "common/median.hpp"

namespace slamfuse::laser_slam {
namespace {

constexpr std::size_t kFewestReadings = 20;
/// Wheels do not move the robot this far [m] between two messages: odometry has begun anew.
constexpr double kOdometryReset = 0.5;
/// So far [m], or turned by so much [rad], every beam of a working sensor reads something else.
constexpr double kDriven = 0.05;
constexpr double kTurned = 0.05;
/// Of a scan without noise the third differences of neighbouring readings are typically smaller than this [m]: what is
/// seen is smooth. Noise of half a millimetre makes them larger.
constexpr double kSmooth = 1.5e-3;

/// How many different numbers a scan has: those of drivers that send a number for "nothing" do not count.
std::size_t readings(const std::vector<float>& ranges) {
  std::set<float> different;
  for (const float range : ranges) {
    if (std::isfinite(range)) different.insert(range);
  }
  return different.size();
}

/// Median of the third differences of neighbouring readings [m]; 0 where too few are neighbours.
double roughness(const std::vector<float>& ranges) {
  std::vector<double> differences;
  for (std::size_t i = 3; i < ranges.size(); ++i) {
    const double third = double{ranges[i]} - 3.0 * ranges[i - 1] + 3.0 * ranges[i - 2] - ranges[i - 3];
    if (std::isfinite(third)) differences.push_back(std::abs(third));
  }
  return differences.size() < kFewestReadings ? 0.0 : common::median(std::move(differences));
}

bool same_bits(float a, float b) { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); }

}  // namespace

void FrozenScan::moved_to(const common::Pose2& T_odom_base) {
  const bool is_reset = T_odom_base_ && (T_odom_base_->inverse() * T_odom_base).translation().norm() > kOdometryReset;
  if (is_reset) seen_from_.reset();
  T_odom_base_ = T_odom_base;
}

common::Result<void> FrozenScan::check(const common::LaserScan& scan) {
  const bool repeats = std::equal(scan.ranges.begin(), scan.ranges.end(), ranges_.begin(), ranges_.end(), same_bits) &&
                       readings(ranges_) >= kFewestReadings;
  if (!repeats || !seen_from_ || !T_odom_base_) {
    ranges_ = scan.ranges;
    seen_from_ = T_odom_base_;
    return {};
  }
  const common::Pose2 driven = seen_from_->inverse() * *T_odom_base_;
  const double distance = driven.translation().norm();
  if (distance < kDriven && std::abs(driven.theta) < kTurned) return {};
  if (roughness(ranges_) <= kSmooth) return {};
  return common::failed(
      fmt::format("the scan repeats an earlier one in every range, although the wheels have driven "
                  "{:.2f} m and turned by {:.2f} rad since: the sensor is frozen",
                  distance, driven.theta));
}

}  // namespace slamfuse::laser_slam
