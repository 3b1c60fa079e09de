// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include "common/angle.hpp"
#include "common/calibration.hpp"
#include "common/pose2.hpp"
#include "common/sensor_message.hpp"
#include "laser_slam/random_stream.hpp"

namespace slamfuse::laser_slam::testing {

/// Walls as line segments [m].
using Walls = std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>>;

inline void add_box(Walls& walls, double x0, double y0, double x1, double y1) {
  const Eigen::Vector2d a(x0, y0), b(x1, y0), c(x1, y1), d(x0, y1);
  walls.insert(walls.end(), {{a, b}, {b, c}, {c, d}, {d, a}});
}

/// A room of 8 m x 6 m with a cupboard and a pillar: nothing in it is symmetric.
inline Walls room() {
  Walls walls;
  add_box(walls, -3.03, -2.02, 5.02, 4.01);
  add_box(walls, 1.52, 2.51, 2.73, 4.01);
  add_box(walls, -1.11, -1.53, -0.72, -1.04);
  return walls;
}

/// A square ring of corridors 2 m wide, 14 m outside, with niches: a loop of about 48 m.
inline Walls ring() {
  Walls walls;
  add_box(walls, -1.0, -1.0, 13.0, 13.0);
  add_box(walls, 1.0, 1.0, 11.0, 11.0);
  add_box(walls, 3.1, -1.0, 3.6, -0.6);
  add_box(walls, 8.2, 0.7, 8.9, 1.0);
  add_box(walls, 12.5, 5.3, 13.0, 6.2);
  add_box(walls, 6.4, 12.6, 7.0, 13.0);
  add_box(walls, -1.0, 8.1, -0.6, 9.4);
  add_box(walls, 0.6, 4.0, 1.0, 4.3);
  return walls;
}

/// Distance from a point along a direction to the nearest wall [m], infinite without one.
inline double cast(const Walls& walls, const Eigen::Vector2d& from, double bearing) {
  const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [a, b] : walls) {
    Eigen::Matrix2d system;
    system << direction, a - b;
    if (std::abs(system.determinant()) < 1e-12) continue;
    const Eigen::Vector2d solution = system.inverse() * (a - from);
    if (solution.x() > 0.0 && solution.y() >= 0.0 && solution.y() <= 1.0) nearest = std::min(nearest, solution.x());
  }
  return nearest;
}

inline common::LaserCalibration full_circle_laser(int beams = 180) {
  common::LaserCalibration laser;
  laser.angle_min = -common::to_radians(180.0);
  laser.angle_increment = common::to_radians(360.0) / beams;
  laser.beams = beams;
  laser.range_min = 0.05;
  laser.range_max = 12.0;
  return laser;
}

/// What a laser measures while base_link moves along `pose_after(seconds since the first beam)`.
inline common::LaserScan scan_at(const Walls& walls, const common::LaserCalibration& laser, common::Nanoseconds stamp,
                                 const std::function<common::Pose2(double)>& pose_after, RandomStream* noise = nullptr,
                                 double sigma = 0.01) {
  common::LaserScan scan;
  scan.stamp = stamp;
  scan.sensor = "laser0";
  for (int i = 0; i < laser.beams; ++i) {
    const common::Pose3 laser_pose =
        common::to_pose3(pose_after(laser.sweep_duration * i / (laser.beams - 1))) * laser.T_base_laser;
    const double bearing = laser.angle_min + i * laser.angle_increment;
    const Eigen::Vector3d direction = laser_pose.rotation * Eigen::Vector3d(std::cos(bearing), std::sin(bearing), 0.0);
    double range = cast(walls, laser_pose.translation.head<2>(), std::atan2(direction.y(), direction.x()));
    if (noise) range += sigma * noise->normal();
    scan.ranges.push_back(range < laser.range_max ? static_cast<float>(range) : HUGE_VALF);
  }
  return scan;
}

inline common::LaserScan scan_at(const Walls& walls, const common::LaserCalibration& laser, common::Nanoseconds stamp,
                                 const common::Pose2& pose, RandomStream* noise = nullptr, double sigma = 0.01) {
  return scan_at(
      walls, laser, stamp, [&](double) { return pose; }, noise, sigma);
}

/// Distance [m] between two poses' positions.
inline double distance(const common::Pose2& a, const common::Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

}  // namespace slamfuse::laser_slam::testing
