// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <Eigen/Core>

#include "common/calibration.hpp"
#include "visual_slam/body_pose.hpp"

namespace slamfuse::visual_slam {

/// A calibrated camera with what the filter needs of it at hand.
struct Camera {
  Camera(std::string camera_name, const common::CameraCalibration& camera_calibration);

  std::string name;
  common::CameraCalibration calibration;
  Eigen::Matrix3d R_base_camera;  ///< optical frame (x right, y down, z forward) to base_link
  Eigen::Vector3d t_base_camera;  ///< optical centre in base_link [m]
  double focal_length;            ///< mean of fx and fy [px]

  /// Whether a pixel lies in the image, at least `border` [px] from its edges.
  bool sees(const Eigen::Vector2d& pixel, double border) const;
  /// How long after the image's stamp the row of `pixel` was exposed [s] (rolling shutter, the stamp is the middle
  /// row).
  double row_delay(const Eigen::Vector2d& pixel) const;
};

/// What was measured of one landmark in one image.
struct Bearing {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();  ///< normalised undistorted image point (x/z, y/z)
  double sigma = 0.002;                             ///< standard deviation of each coordinate
  /// base_link at the exposure of this very row, in base_link at the image's stamp (rolling shutter).
  BodyPose row_shift;
};

/// The bearing of a pixel; `twist` is how base_link moves at the image's stamp.
Bearing make_bearing(const Camera& camera, const Eigen::Vector2d& pixel, double pixel_sigma, const BodyTwist& twist);

}  // namespace slamfuse::visual_slam
