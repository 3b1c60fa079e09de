// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "common/pose3.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/projection.hpp"

namespace slamfuse::visual_slam::testing {

/// A camera looking along base_link's x axis turned left by `yaw`, mounted 0.7 m high.
inline Camera make_camera(const std::string& name, double yaw, double x = 0.1, double y = 0.05) {
  common::CameraCalibration calibration;
  Eigen::Matrix3d optical;  // camera looking along x: right is -y, down is -z
  optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  calibration.T_base_camera.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() * optical);
  calibration.T_base_camera.translation = {x, y, 0.7};
  calibration.width = 640;
  calibration.height = 480;
  calibration.fx = calibration.fy = 500.0;
  calibration.cx = 319.5;
  calibration.cy = 239.5;
  return {name, calibration};
}

/// Gaussian numbers that are the same with every standard library.
class Noise {
 public:
  explicit Noise(unsigned seed) : engine_(seed) {}
  double uniform() { return (static_cast<double>(engine_()) + 0.5) / 4294967296.0; }
  double gaussian() { return std::sqrt(-2.0 * std::log(uniform())) * std::cos(2.0 * std::numbers::pi * uniform()); }

 private:
  std::mt19937 engine_;
};

/// Points on the walls of a room of 8 m x 6 m about the origin.
inline std::vector<Eigen::Vector3d> room_points(int count, Noise& noise) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double along = 2.0 * noise.uniform() - 1.0;
    const double height = 2.2 * noise.uniform();
    const double side = noise.uniform() < 0.5 ? -1.0 : 1.0;
    if (i % 2 == 0) {
      points.emplace_back(4.0 * along, 3.0 * side, height);
    } else {
      points.emplace_back(4.0 * side, 3.0 * along, height);
    }
  }
  return points;
}

}  // namespace slamfuse::visual_slam::testing
