// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/scan_beams.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "common/pose2.hpp"

namespace slamfuse::laser_slam {

std::vector<Eigen::Vector2d> thin_hits(const std::vector<Beam>& beams, int most) {
  const auto hits = std::count_if(beams.begin(), beams.end(), [](const Beam& beam) { return beam.hit; });
  std::vector<Eigen::Vector2d> points;
  std::int64_t seen = 0;
  for (const Beam& beam : beams) {
    if (!beam.hit) continue;
    const bool keep = hits <= most || (seen + 1) * most / hits != seen * most / hits;
    if (keep) points.push_back(beam.end);
    ++seen;
  }
  return points;
}

common::Result<void> check_calibration(const std::string& sensor, const common::LaserCalibration& c) {
  const auto refuse = [&](const std::string& what) {
    return common::invalid_input("laser calibration of " + sensor + ": " + what);
  };
  constexpr double kTurn = 2.0 * std::numbers::pi;
  if (!(std::abs(c.angle_min) <= kTurn)) {
    return refuse(fmt::format("angle_min is {}, allowed is a turn to either side", c.angle_min));
  }
  if (!(std::abs(c.angle_increment) <= kTurn) || c.angle_increment == 0.0) {
    return refuse(fmt::format("angle_increment is {}, allowed is a turn to either side, not 0", c.angle_increment));
  }
  if (c.beams < 0) return refuse(fmt::format("beams is {}, allowed is 0 (may vary) or more", c.beams));
  if (!std::isfinite(c.range_min) || c.range_min < 0.0 || !std::isfinite(c.range_max) || c.range_max <= c.range_min) {
    return refuse(
        fmt::format("range_min is {}, range_max {}; allowed is 0 <= range_min < range_max", c.range_min, c.range_max));
  }
  if (!(c.sweep_duration >= 0.0 && c.sweep_duration <= kLongestSweep)) {
    return refuse(fmt::format("sweep_duration is {}, allowed is 0 (unknown) to {} s", c.sweep_duration, kLongestSweep));
  }
  if (!c.T_base_laser.is_finite()) return refuse("the mounting T_base_laser is not finite");
  const double up = std::abs((c.T_base_laser.rotation * Eigen::Vector3d::UnitZ()).z());
  if (up < std::cos(kMaxTilt)) {
    return refuse(fmt::format("the scan plane is tilted by {:.3f} rad, allowed is up to {} (upright or upside down)",
                              std::acos(std::min(up, 1.0)), kMaxTilt));
  }
  return {};
}

common::Result<ScanBeams> project_scan(const common::LaserScan& scan, const common::LaserCalibration& calibration,
                                       const BeamLimits& limits, const Eigen::Vector3d& twist) {
  const std::size_t count = scan.ranges.size();
  if (calibration.beams > 0 && count != static_cast<std::size_t>(calibration.beams)) {
    return common::failed(fmt::format("{} ranges, allowed are {}", count, calibration.beams));
  }
  if (count < 2) return common::failed(fmt::format("{} ranges, allowed are 2 or more", count));
  const double longest = std::min(limits.max_range, calibration.range_max);
  const double free_length = std::min(limits.free_beyond_range, longest);
  ScanBeams result;
  result.beams.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double range = static_cast<double>(scan.ranges[i]);
    if (std::isnan(range) || range == -HUGE_VAL) continue;
    if (range < 0.0) {
      return common::failed(fmt::format("range {} of beam {}, allowed are 0 or more, inf and NaN", range, i));
    }
    if (range < calibration.range_min) continue;
    const bool hit = range < calibration.range_max && range <= longest;
    if (!hit && free_length <= calibration.range_min) continue;
    const double bearing = calibration.angle_min + static_cast<double>(i) * calibration.angle_increment;
    const double length = hit ? range : free_length;
    const double fired = calibration.sweep_duration * static_cast<double>(i) / static_cast<double>(count - 1);
    const common::Pose2 moved = common::exp_se2(twist * fired);  // base_link at the first beam <- at this beam
    const Eigen::Vector3d end =
        calibration.T_base_laser * Eigen::Vector3d(length * std::cos(bearing), length * std::sin(bearing), 0.0);
    const Eigen::Vector2d mount = calibration.T_base_laser.translation.head<2>();
    result.beams.push_back({moved * mount, moved * Eigen::Vector2d(end.head<2>()), hit});
  }
  if (result.beams.empty())
    return common::failed(
        "no usable beam: all are NaN, below range_min, or saw nothing and free_beyond_range is below range_min");
  result.match_points = thin_hits(result.beams, limits.max_match_points);
  return result;
}

}  // namespace slamfuse::laser_slam
