// SPDX-License-Identifier: BSD-3-Clause
#include "common/calibration.hpp"

#include <gtest/gtest.h>

namespace slamfuse::common {
namespace {

struct NamedCamera {
  const char* name;
  CameraCalibration camera;
};

CameraCalibration camera(double f, double k1, double k2, double p1, double p2, double k3) {
  CameraCalibration result;
  result.width = 640;
  result.height = 480;
  result.fx = f;
  result.fy = 1.01 * f;
  result.cx = 318.5;
  result.cy = 241.2;
  result.k1 = k1;
  result.k2 = k2;
  result.p1 = p1;
  result.p2 = p2;
  result.k3 = k3;
  return result;
}

class Cameras : public testing::TestWithParam<NamedCamera> {};

INSTANTIATE_TEST_SUITE_P(Lenses, Cameras,
                         testing::Values(NamedCamera{"NoDistortion", camera(522, 0, 0, 0, 0, 0)},
                                         NamedCamera{"MildBarrel", camera(522, -0.09, 0.03, 0, 0, 0)},
                                         NamedCamera{"StrongBarrel", camera(458, -0.28, 0.074, 1.9e-4, 1.8e-5, 0)},
                                         NamedCamera{"Pincushion", camera(500, 0.12, 0.02, 0, 0, 0)},
                                         NamedCamera{"AllTerms", camera(533, -0.27, -0.02, 1e-3, -5e-4, 0.23)}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(Cameras, ProjectWhereUndistortLooks) {
  const CameraCalibration& lens = GetParam().camera;
  for (int v = 0; v < lens.height; v += 20) {
    for (int u = 0; u < lens.width; u += 20) {
      const Eigen::Vector2d ray = lens.undistort({u, v});
      const auto pixel = lens.project(Eigen::Vector3d(3.0 * ray.x(), 3.0 * ray.y(), 3.0));
      ASSERT_TRUE(pixel.has_value()) << u << " " << v;
      EXPECT_NEAR((*pixel - Eigen::Vector2d(u, v)).norm(), 0.0, 1e-9) << u << " " << v;
    }
  }
}

TEST_P(Cameras, JacobianAgreesWithFiniteDifferences) {
  const CameraCalibration& lens = GetParam().camera;
  const double step = 1e-6;
  for (const double x : {-0.6, -0.1, 0.0, 0.3}) {
    for (const double y : {-0.4, 0.0, 0.45}) {
      const Eigen::Vector2d at(x, y);
      Eigen::Matrix2d numeric;
      for (int i = 0; i < 2; ++i) {
        const Eigen::Vector2d offset = step * Eigen::Vector2d::Unit(i);
        numeric.col(i) = (lens.distort(at + offset) - lens.distort(at - offset)) / (2.0 * step);
      }
      EXPECT_NEAR((lens.distort_jacobian(at) - numeric).norm(), 0.0, 1e-5) << x << " " << y;
    }
  }
}

TEST_P(Cameras, SeeNothingBehindThem) {
  const CameraCalibration& lens = GetParam().camera;
  EXPECT_FALSE(lens.project({0.1, 0.1, 0.0}).has_value());
  EXPECT_FALSE(lens.project({0.1, 0.1, -2.0}).has_value());
  EXPECT_TRUE(lens.project({0.1, 0.1, 2.0}).has_value());
}

TEST(CameraCalibration, ProjectsThePrincipalAxisToThePrincipalPoint) {
  EXPECT_EQ(camera(522, -0.09, 0.03, 1e-3, 1e-3, 0).project({0, 0, 7}), Eigen::Vector2d(318.5, 241.2));
}

TEST(CameraCalibration, LetsNoPointFarOutsideFoldIntoTheImage) {
  const CameraCalibration lens = camera(458, -0.4, 0.05, 0, 0, 0);
  // The distorted radius grows until r = 1.03, falls until r = 1.93 and grows again.
  EXPECT_TRUE(lens.project({1.0, 0, 1}).has_value());
  EXPECT_FALSE(lens.project({1.5, 0, 1}).has_value());
  EXPECT_FALSE(lens.project({2.1, 0, 1}).has_value()) << "behind the fold the polynomial grows again";
  EXPECT_FALSE(lens.project({100.0, 0, 1}).has_value());
}

TEST(CameraCalibration, SeesFarToTheSideWhereTheLensDoesNotFold) {
  const CameraCalibration lens = camera(500, 0.1, 0.01, 0, 0, 0.001);
  EXPECT_TRUE(lens.project({20.0, 0, 1}).has_value());
  EXPECT_TRUE(camera(500, 0, 0, 0, 0, 0).project({1e4, 0, 1}).has_value());
}

}  // namespace
}  // namespace slamfuse::common
