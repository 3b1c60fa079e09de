// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/camera_tracks.hpp"

#include <cmath>

namespace slamfuse::visual_slam {
namespace {

// A picture cannot stay the same to the last bit when the robot moves this far.
constexpr double kClearMove = 0.01;  // [m]
constexpr double kClearTurn = 0.01;  // [rad]

}  // namespace

bool CameraTracks::is_frozen(const common::Image& image, const common::Pose2& odometry) {
  const bool same = pixels_ && *pixels_ == *image.pixels;
  const common::Pose2 driven = odometry_pose_.inverse() * odometry;
  if (same && (driven.translation().norm() > kClearMove || std::abs(driven.theta) > kClearTurn)) return true;
  if (!same) {
    pixels_ = image.pixels;
    odometry_pose_ = odometry;
  }
  return false;
}

}  // namespace slamfuse::visual_slam
