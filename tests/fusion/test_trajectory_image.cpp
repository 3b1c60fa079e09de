// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/trajectory_image.hpp"

#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace slamfuse::fusion {
namespace {

TEST(TrajectoryImageMatrix, FillsTheImageFromZeroToItsSizeOnBothAxes) {
  const Points points = {{-1.0, 4.0}, {3.0, 5.0}, {0.0, 14.0}};

  const auto matrix = trajectory_image_matrix(points, 1000.0, ImagePlane::kLift);

  ASSERT_TRUE(matrix.has_value());
  const Points image = transformed(points, *matrix);
  EXPECT_NEAR(image[0].x(), 0.0, 1e-9);
  EXPECT_NEAR(image[1].x(), 1000.0, 1e-9);
  EXPECT_NEAR(image[0].y(), 0.0, 1e-9);
  EXPECT_NEAR(image[2].y(), 1000.0, 1e-9);
  EXPECT_NEAR(image[1].y(), 100.0, 1e-9);
}

TEST(TrajectoryImageMatrix, LiftsTheFloorIntoThePlaneZOneAsEquationOnePrints) {
  const Points points = {{0.0, 0.0}, {2.0, 4.0}};

  const Eigen::Matrix4d lift = *trajectory_image_matrix(points, 10.0, ImagePlane::kLift);
  const Eigen::Matrix4d keep = *trajectory_image_matrix(points, 10.0, ImagePlane::kKeep);

  EXPECT_EQ((lift * Eigen::Vector4d(1, 1, 0, 1)).z(), 1.0);
  EXPECT_EQ((keep * Eigen::Vector4d(1, 1, 1, 1)).z(), 1.0);
  EXPECT_EQ(lift(0, 0), 5.0);  // 1 / P_x = w / (x_max - x_min)
  EXPECT_EQ(lift(1, 1), 2.5);
}

TEST(TrajectoryImageMatrix, RefusesPathsWithoutExtentAndPointsThatAreNotFinite) {
  EXPECT_FALSE(trajectory_image_matrix({}, 10.0, ImagePlane::kLift).has_value());
  EXPECT_FALSE(trajectory_image_matrix({{0, 0}, {0, 5}}, 10.0, ImagePlane::kLift).has_value());
  EXPECT_FALSE(
      trajectory_image_matrix({{0, 0}, {std::numeric_limits<double>::quiet_NaN(), 5}, {1, 1}}, 10.0, ImagePlane::kLift)
          .has_value());
}

TEST(AlignedAngleRotation, TurnsCounterClockwiseAboutTheCorner) {
  const Points turned = transformed({{2.0, 0.0}}, aligned_angle_rotation(0.5 * std::numbers::pi));

  EXPECT_NEAR(turned[0].x(), 0.0, 1e-12);
  EXPECT_NEAR(turned[0].y(), 2.0, 1e-12);
}

}  // namespace
}  // namespace slamfuse::fusion
