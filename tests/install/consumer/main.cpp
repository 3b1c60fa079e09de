// SPDX-License-Identifier: BSD-3-Clause
// Exits with 0 when the installed libraries link and align a path with itself turned by a right angle.
#include <cmath>
#include <cstdlib>

#include "common/trajectory.hpp"
#include "fusion/alignment.hpp"
#include "laser_slam/laser_slam.hpp"
#include "visual_slam/visual_slam.hpp"

int main() {
  using namespace slamfuse;
  if (laser_slam::LaserSlam::create({}, "laser0", {}, 1, 1) || visual_slam::VisualSlam::create({}, {}, 1, 1)) {
    return EXIT_FAILURE;  // a laser without beams and no camera at all must be refused
  }
  common::Trajectory2 laser;
  common::Trajectory2 visual;
  const common::Pose2 turn{1.0, 2.0, M_PI / 2};
  for (int i = 0; i < 200; ++i) {
    const double t = 0.05 * i;
    const common::Pose2 pose{3.0 * std::cos(t), 2.0 * std::sin(2.0 * t) + t, t};
    visual.push_back({i * common::kNanosecondsPerSecond / 5, pose});
    laser.push_back({i * common::kNanosecondsPerSecond / 5, turn * pose});
  }
  const fusion::Alignment alignment = fusion::align_trajectories(laser, visual, {});
  return std::abs(alignment.rotation_deg - 90.0) < 0.01 ? EXIT_SUCCESS : EXIT_FAILURE;
}
