// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/calibration.hpp"
#include "common/error.hpp"
#include "common/sensor_message.hpp"

namespace slamfuse::laser_slam {

/// One beam of a sweep, in base_link at the sweep's first beam.
struct Beam {
  Eigen::Vector2d origin;  ///< of the laser when it was fired [m]
  Eigen::Vector2d end;     ///< what it hit, or how far it is known to be free [m]
  bool hit = false;        ///< whether it ended on a surface
};

/// A scan ready for matching and mapping.
struct ScanBeams {
  std::vector<Beam> beams;                    ///< all that can be used, in firing order
  std::vector<Eigen::Vector2d> match_points;  ///< ends of evenly thinned hits [m]
};

/// Evenly chosen ends of the beams that hit, at most `most`.
std::vector<Eigen::Vector2d> thin_hits(const std::vector<Beam>& beams, int most);

/// Which beams are used.
struct BeamLimits {
  double max_range = 80.0;         ///< farther returns only tell what is free before them [m]
  double free_beyond_range = 4.0;  ///< length of a beam without return [m]
  int max_match_points = 360;      ///< thin the hits to at most this many for matching
};

/// Checks a calibration LaserSlam cannot work with: increment 0, negative beam number, impossible ranges, numbers that
/// are not finite, a scan plane tilted by more than kMaxTilt against the floor.
common::Result<void> check_calibration(const std::string& sensor, const common::LaserCalibration& calibration);
inline constexpr double kLongestSweep = 60.0;  ///< [s]; scans that take longer are refused
inline constexpr double kMaxTilt = 0.1;        ///< [rad]; the projection onto the floor then errs by half a per cent

/// Projects a scan onto the floor plane in base_link at its first beam. `twist` is base_link's motion during the sweep
/// (vx, vy, omega) [m/s, rad/s] in its own frame: beam i of n left at i / (n - 1) of the sweep duration. Beams follow
/// the ROS conventions: NaN, -inf and ranges below range_min are no measurement; +inf and ranges from range_max up saw
/// nothing. Errors (kFailed, the reason): not as many ranges as calibrated, a negative range, no usable beam.
common::Result<ScanBeams> project_scan(const common::LaserScan& scan, const common::LaserCalibration& calibration,
                                       const BeamLimits& limits, const Eigen::Vector3d& twist);

}  // namespace slamfuse::laser_slam
