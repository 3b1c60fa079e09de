// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "common/pose2.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/synthetic_world.hpp"
#include "visual_slam/turn_by_way.hpp"

namespace slamfuse::visual_slam::testing {

/// A robot that drives evenly, and the features that its camera follows from one picture to the next.
struct EvenDrive {
  double seconds = 0.2;
  double way = 0.0;        ///< from picture to picture [m]
  double turn = 0.0;       ///< [rad]
  double last_turn = 0.0;  ///< in the step before, as long and as far [rad]

  /// base_link so long after the first picture's stamp, seen from base_link at that stamp. While the first picture is
  /// exposed it still turns as in the step before.
  common::Pose2 pose(double time) const {
    return common::exp_se2(time / seconds * Eigen::Vector3d(way, 0.0, time < 0.5 * seconds ? last_turn : turn));
  }
};

/// Where a point of base_link at the first stamp appears in the picture of a stamp `time` later, each row of which is
/// exposed in its turn.
inline std::optional<Eigen::Vector2d> appearance(const Camera& camera, const EvenDrive& drive,
                                                 const Eigen::Vector3d& point, double time) {
  std::optional<Eigen::Vector2d> pixel;
  double delay = 0.0;
  for (int round = 0; round < 5; ++round) {
    const Eigen::Vector2d at = drive.pose(time + delay).inverse() * Eigen::Vector2d(point.head<2>());
    pixel = camera.calibration.project(camera.R_base_camera.transpose() *
                                       (Eigen::Vector3d(at.x(), at.y(), point.z()) - camera.t_base_camera));
    if (!pixel) return std::nullopt;
    delay = camera.row_delay(*pixel);
  }
  return pixel;
}

/// So many features all over the picture, of points 0.5 to 8 m deep, found with an error of 0.2 px.
inline std::vector<FollowedFeature> follow(const Camera& camera, const EvenDrive& drive, int count, Noise& noise) {
  std::vector<FollowedFeature> features;
  const auto blurred = [&noise](const Eigen::Vector2d& pixel) -> Eigen::Vector2d {
    return pixel + 0.2 * Eigen::Vector2d(noise.gaussian(), noise.gaussian());
  };
  while (static_cast<int>(features.size()) < count) {
    const Eigen::Vector2d somewhere(noise.uniform() * camera.calibration.width,
                                    noise.uniform() * camera.calibration.height);
    const double depth = 0.5 + 7.5 * noise.uniform();
    const Eigen::Vector3d point =
        camera.t_base_camera + camera.R_base_camera * (depth * camera.calibration.undistort(somewhere).homogeneous());
    const auto before = appearance(camera, drive, point, 0.0);
    const auto now = appearance(camera, drive, point, drive.seconds);
    if (!before || !now || !camera.sees(*before, 0.0) || !camera.sees(*now, 0.0)) continue;
    features.push_back({blurred(*before), blurred(*now)});
  }
  return features;
}

}  // namespace slamfuse::visual_slam::testing
