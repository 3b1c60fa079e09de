// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "laser_slam/loop_detector_options.hpp"

namespace slamfuse::laser_slam {

/// Tells when the robot, after a long way through new or recent space, meets surfaces it saw long ago.
class LoopDetector {
 public:
  explicit LoopDetector(const LoopDetectorOptions& options) : options_(options) {}

  /// Surfaces last seen before this path length [m] are old.
  double old_before(double path_length) const { return path_length - options_.min_path; }

  /// Takes the share of a scan's beams that met old surfaces; true when this scan closes a loop.
  bool closes(double old_share, double path_length);

 private:
  LoopDetectorOptions options_;
  bool on_old_ground_ = false;
  double left_at_ = 0.0;  // path length when old ground was last stood on [m]
};

}  // namespace slamfuse::laser_slam
