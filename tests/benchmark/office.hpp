// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/calibration.hpp"
#include "common/pose2.hpp"
#include "common/sensor_message.hpp"
#include "laser_slam/random_stream.hpp"

namespace slamfuse {

/// How an office building is laid out: corridors along x and along y that cross, evenly spaced, the outer ones on the
/// edge.
struct OfficePlan {
  double width = 20.0;   ///< between the centre lines of the outermost corridors along y [m]
  double height = 15.0;  ///< the same along x
  int rows = 2;          ///< corridors along x
  int columns = 2;       ///< corridors along y

  double corridor_length() const { return rows * width + columns * height; }
};

/// A made-up building: corridors 2.4 m wide with furniture along the walls and open doors to rooms of 4 m x 5 m. The
/// same plan gives the same building.
class Office {
 public:
  explicit Office(const OfficePlan& plan);

  /// Distance from a point along a direction to the nearest wall [m], no more than `farthest`.
  double cast(const Eigen::Vector2d& from, double bearing, double farthest) const;

  /// A drive along every corridor, from (0, 0): one pose every `step` [m], turning on the spot by at most 0.3 rad a
  /// pose.
  std::vector<common::Pose2> drive(double step) const;

 private:
  using Segment = std::pair<Eigen::Vector2d, Eigen::Vector2d>;

  void add_segment(const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  void add_box(const Eigen::Vector2d& corner, const Eigen::Vector2d& opposite);
  void add_side(bool along_x, int corridor, double side, laser_slam::RandomStream& random);
  const std::vector<int>* bucket(int x, int y) const;

  OfficePlan plan_;
  std::vector<Segment> segments_;
  Eigen::Vector2d low_;  // of the buckets
  int bucket_columns_ = 0;
  int bucket_rows_ = 0;
  std::vector<std::vector<int>> buckets_;  // the segments that touch a square of the floor
};

/// A laser of this many beams over 270 degrees (over the full circle minus one step from 300 beams up), 0.05 to 30 m.
common::LaserCalibration office_laser(int beams);

/// What it measures at a pose of base_link, with 1 cm of noise; farther than its range is +inf.
common::LaserScan office_scan(const Office& office, const common::LaserCalibration& laser, common::Nanoseconds stamp,
                              const common::Pose2& pose, laser_slam::RandomStream& noise);

}  // namespace slamfuse
