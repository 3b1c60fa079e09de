// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/view_cone.hpp"

#include <gtest/gtest.h>

#include <random>

#include <Eigen/Geometry>

namespace slamfuse::visual_slam {
namespace {

common::CameraCalibration wide_camera() {
  common::CameraCalibration calibration;
  calibration.width = 640;
  calibration.height = 480;
  calibration.fx = calibration.fy = 330.0;
  calibration.cx = 300.0;
  calibration.cy = 250.0;
  calibration.k1 = -0.12;
  calibration.k2 = 0.015;
  return calibration;
}

struct Count {
  int shown = 0;
  int in_cone = 0;
  int missed = 0;  // shown though not in the cone
};

/// Of points all around a camera that looks somewhere from somewhere.
Count count(const common::CameraCalibration& calibration) {
  const Camera camera("cam", calibration);
  const Eigen::Vector3d centre(1.0, -2.0, 0.5);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2.0, Eigen::Vector3d(1.0, -1.0, 0.5).normalized()).toRotationMatrix();
  const ViewCone cone(camera, centre, turn.col(2));
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> number(-5.0, 5.0);
  Count result;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d point = centre + Eigen::Vector3d(number(engine), number(engine), number(engine));
    const auto pixel = calibration.project(turn.transpose() * (point - centre));
    const bool shown = pixel && camera.sees(*pixel, 0.0);
    const bool in_cone = cone.may_show(point);
    result.shown += shown ? 1 : 0;
    result.in_cone += in_cone ? 1 : 0;
    result.missed += shown && !in_cone ? 1 : 0;
  }
  return result;
}

TEST(ViewCone, HoldsAllThatIsInThePictureAndLittleElse) {
  const Count points = count(wide_camera());
  EXPECT_GT(points.shown, 300);
  EXPECT_EQ(points.missed, 0);
  EXPECT_LT(points.in_cone, 3 * points.shown);
}

TEST(ViewCone, IsAllInFrontOfALensWhoseModelEndsBeforeTheCorners) {
  common::CameraCalibration calibration = wide_camera();
  calibration.k1 = -0.4;
  calibration.k2 = 0.0;
  const Count points = count(calibration);
  EXPECT_GT(points.shown, 100);
  EXPECT_EQ(points.missed, 0);
  EXPECT_NEAR(points.in_cone, 2500, 200);
}

}  // namespace
}  // namespace slamfuse::visual_slam
