// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "common/time.hpp"

namespace slamfuse::common {

/// One sweep of a planar laser. The stamp is that of the first beam; the beams follow each other evenly until
/// `stamp + sweep_duration`. The mounting `T_base_laser` and the geometry are in the recording's LaserCalibration.
struct LaserScan {
  Nanoseconds stamp = 0;
  std::string sensor;         ///< name of the sensor, e.g. "laser0"
  std::vector<float> ranges;  ///< [m], first beam first; +inf = nothing within range, NaN = no measurement
};

/// One gray camera picture, already decoded. The pixels are shared, not copied, and never change.
struct Image {
  Nanoseconds stamp = 0;
  std::string sensor;                                       ///< name of the camera, e.g. "cam0"
  int width = 0;                                            ///< [px]
  int height = 0;                                           ///< [px]
  std::shared_ptr<const std::vector<std::uint8_t>> pixels;  ///< row-major, width * height bytes, 0 black to 255 white
};

/// Pose and speed from wheel encoders, integrated in the odometry's own frame.
struct WheelOdometry {
  Nanoseconds stamp = 0;
  std::string sensor;          ///< e.g. "odom0"
  Pose2 pose;                  ///< T_odom_base
  double forward_speed = 0.0;  ///< [m/s], 0 where the source does not tell
  double turn_rate = 0.0;      ///< [rad/s], 0 where the source does not tell
};

/// Angular velocity and specific force in the sensor's frame.
struct Imu {
  Nanoseconds stamp = 0;
  std::string sensor;                                             ///< e.g. "imu0"
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();     ///< [rad/s]
  Eigen::Vector3d linear_acceleration = Eigen::Vector3d::Zero();  ///< [m/s^2]
};

/// A pose of base_link that another SLAM system found, in its own map frame.
struct ExternalPose {
  Nanoseconds stamp = 0;
  std::string sensor;                         ///< "laser_pose" or "visual_pose", whose half it takes the place of
  std::string frame;                          ///< of its map
  Pose2 pose;                                 ///< T_map_base, in the map's own unit of length
  std::optional<Eigen::Matrix3d> covariance;  ///< of (x, y, theta) in the map frame; empty: not told
  std::uint64_t publisher = 0;                ///< another number when the system was started again
};

using SensorMessage = std::variant<WheelOdometry, LaserScan, Image, Imu, ExternalPose>;

/// The sensor's own stamp, whatever the kind.
inline Nanoseconds stamp_of(const SensorMessage& message) {
  return std::visit([](const auto& m) { return m.stamp; }, message);
}

/// The sensor's name, whatever the kind.
inline const std::string& sensor_of(const SensorMessage& message) {
  return std::visit([](const auto& m) -> const std::string& { return m.sensor; }, message);
}

}  // namespace slamfuse::common
