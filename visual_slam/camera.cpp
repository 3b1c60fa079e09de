// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/camera.hpp"

#include <utility>

namespace slamfuse::visual_slam {

Camera::Camera(std::string camera_name, const common::CameraCalibration& camera_calibration)
    : name(std::move(camera_name)),
      calibration(camera_calibration),
      R_base_camera(camera_calibration.T_base_camera.rotation.toRotationMatrix()),
      t_base_camera(camera_calibration.T_base_camera.translation),
      focal_length(0.5 * (camera_calibration.fx + camera_calibration.fy)) {}

bool Camera::sees(const Eigen::Vector2d& pixel, double border) const {
  return pixel.x() >= border && pixel.y() >= border && pixel.x() <= calibration.width - 1 - border &&
         pixel.y() <= calibration.height - 1 - border;
}

double Camera::row_delay(const Eigen::Vector2d& pixel) const {
  return calibration.readout * ((pixel.y() + 0.5) / calibration.height - 0.5);
}

Bearing make_bearing(const Camera& camera, const Eigen::Vector2d& pixel, double pixel_sigma, const BodyTwist& twist) {
  return {.point = camera.calibration.undistort(pixel),
          .sigma = pixel_sigma / camera.focal_length,
          .row_shift = displacement(twist, camera.row_delay(pixel))};
}

}  // namespace slamfuse::visual_slam
