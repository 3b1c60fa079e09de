// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "common/pose3.hpp"

namespace slamfuse::common {

/// Geometry and mounting of a planar laser.
struct LaserCalibration {
  Pose3 T_base_laser;            ///< laser frame (x forward, y left, z up; upside down: rolled by pi) in base_link
  double angle_min = 0.0;        ///< bearing of the first beam [rad]
  double angle_increment = 0.0;  ///< between beams [rad], not 0
  int beams = 0;                 ///< ranges in every scan; 0 where it may vary
  double range_min = 0.0;        ///< [m]
  double range_max = 0.0;        ///< [m]
  double sweep_duration = 0.0;   ///< from the first beam to the last [s]; 0 = unknown or instantaneous
};

/// Pinhole camera with radial-tangential (Brown) distortion, and its mounting.
struct CameraCalibration {
  Pose3 T_base_camera;  ///< optical frame (x right, y down, z forward) in base_link
  int width = 0;        ///< [px]
  int height = 0;       ///< [px]
  double fx = 0.0;      ///< focal lengths [px]
  double fy = 0.0;      ///< [px]
  double cx = 0.0;      ///< principal point [px]; pixel centres are at whole numbers
  double cy = 0.0;      ///< [px]
  double k1 = 0.0;      ///< radial
  double k2 = 0.0;      ///< radial
  double p1 = 0.0;      ///< tangential
  double p2 = 0.0;      ///< tangential
  double k3 = 0.0;      ///< radial
  /// Rolling shutter: time from the first row to the last [s], the image's stamp being that of the middle row. 0 =
  /// global shutter, or unknown.
  double readout = 0.0;

  /// A point in the camera frame [m] with z > 0 as a pixel. Returns nothing for points behind the camera or so far
  /// out that the radial polynomial has turned back.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const;
  /// The distorted pixel of a normalised image point (x/z, y/z).
  Eigen::Vector2d distort(const Eigen::Vector2d& normalized) const;
  /// The normalised image point (x/z, y/z) of a pixel: the distortion undone by Newton iterations.
  Eigen::Vector2d undistort(const Eigen::Vector2d& pixel) const;
  /// Jacobian of distort() at a normalised point.
  Eigen::Matrix2d distort_jacobian(const Eigen::Vector2d& normalized) const;
};

/// What a recording or a configuration knows about its sensors, by sensor name ("laser0", "cam0", ...).
struct Calibration {
  std::map<std::string, LaserCalibration> lasers;
  std::map<std::string, CameraCalibration> cameras;
};

}  // namespace slamfuse::common
