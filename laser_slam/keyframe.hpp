// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "laser_slam/particle_filter.hpp"
#include "laser_slam/scan_beams.hpp"

namespace slamfuse::laser_slam {

/// A scan kept for later in 17 bytes a beam.
class StoredScan {
 public:
  StoredScan() = default;
  explicit StoredScan(const ScanBeams& scan);

  bool empty() const { return beams_.empty(); }
  /// As it was but for rounding to single precision.
  ScanBeams restore() const;

 private:
  struct StoredBeam {
    Eigen::Vector2f origin, end;
  };
  std::vector<StoredBeam> beams_;
  std::vector<std::uint8_t> hits_;
  int match_points_ = 0;
};

/// What the filter was told at one of its updates, kept to tell the path again in hindsight.
struct Keyframe {
  StoredScan scan;           ///< empty where the pose was set from outside
  double path_length = 0.0;  ///< [m] since the map was begun
  bool mapped = false;       ///< agreed well enough to be drawn into the maps
  /// What the motion from the keyframe before may have been: as the filter believed and, where the match was followed
  /// against the prediction, as predicted. None for the first keyframe and where the pose was set from outside.
  std::vector<MotionSinceUpdate> motions;
};

}  // namespace slamfuse::laser_slam
