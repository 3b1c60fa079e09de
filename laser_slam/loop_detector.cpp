// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/loop_detector.hpp"

namespace slamfuse::laser_slam {

bool LoopDetector::closes(double old_share, double path_length) {
  if (on_old_ground_) {
    on_old_ground_ = old_share >= options_.leave_share;
    left_at_ = path_length;
    return false;
  }
  if (old_share < options_.enter_share) return false;
  on_old_ground_ = true;
  const bool long_since = path_length - left_at_ >= options_.min_path;
  left_at_ = path_length;
  return long_since;
}

}  // namespace slamfuse::laser_slam
