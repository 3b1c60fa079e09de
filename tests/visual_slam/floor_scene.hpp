// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "common/pose2.hpp"
#include "visual_slam/camera.hpp"

namespace slamfuse::visual_slam::testing {

/// Blots some centimetres wide, everywhere different.
inline double blots(double x, double y) {
  double value = 0.0;
  for (int wave = 0; wave < 10; ++wave) {
    const double direction = 2.4 * wave;
    const double number = 25.0 + 7.3 * wave;  // [rad/m]
    value += std::sin(number * (x * std::cos(direction) + y * std::sin(direction)) + 1.7 * wave * wave);
  }
  return 120.0 + 22.0 * value;
}

/// A plain with a wall across x = `wall`.
class FloorScene {
 public:
  std::function<double(double, double)> floor = blots;
  double height = 0.0;  ///< of the plain [m]; above 0 it is a bed, and there is no floor
  double wall = 1e9;

  cv::Mat picture(const Camera& camera, const common::Pose2& robot) const {
    cv::Mat image(camera.calibration.height, camera.calibration.width, CV_8UC1);
    for (int row = 0; row < image.rows; ++row) {
      for (int column = 0; column < image.cols; ++column) {
        const Eigen::Vector3d ray = camera.R_base_camera * camera.calibration.undistort({column, row}).homogeneous();
        image.at<unsigned char>(row, column) = cv::saturate_cast<unsigned char>(colour(camera, robot, ray));
      }
    }
    return image;
  }

 private:
  double colour(const Camera& camera, const common::Pose2& robot, const Eigen::Vector3d& ray) const {
    const Eigen::Vector2d centre = robot * Eigen::Vector2d(camera.t_base_camera.head<2>());
    const Eigen::Vector2d along = Eigen::Rotation2Dd(robot.theta) * ray.head<2>();
    const double to_floor = ray.z() < 0.0 ? (height - camera.t_base_camera.z()) / ray.z() : 1e9;
    const double to_wall = along.x() > 0.0 ? (wall - centre.x()) / along.x() : 1e9;
    const double way = std::min(to_floor, to_wall);
    if (way > 30.0) return 128.0;
    const Eigen::Vector2d at = centre + way * along;
    return to_floor < to_wall ? floor(at.x(), at.y()) : blots(at.y(), camera.t_base_camera.z() + way * ray.z());
  }
};

}  // namespace slamfuse::visual_slam::testing
