// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/sensor_message.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/ekf.hpp"

namespace slamfuse::visual_slam {

/// A landmark found in a camera's picture.
struct Track {
  LandmarkId landmark = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// A camera, what is being followed in its pictures, and the picture it showed last.
class CameraTracks {
 public:
  explicit CameraTracks(Camera seeing) : camera(std::move(seeing)) {}

  /// Whether the very same picture came again though the wheels turned: a stuck camera, whose picture says nothing. (To
  /// the filter it would look like a world without depth.) `odometry` is T_odom_base at the image's stamp.
  bool is_frozen(const common::Image& image, const common::Pose2& odometry);

  /// As if no image had come.
  void restart() { *this = CameraTracks(camera); }

  Camera camera;
  std::vector<Track> tracks;
  std::optional<common::Nanoseconds> newest;  ///< stamp of the newest image

 private:
  std::shared_ptr<const std::vector<std::uint8_t>> pixels_;  // of the newest image that differed from the one before
  common::Pose2 odometry_pose_;                              // at that image
};

}  // namespace slamfuse::visual_slam
