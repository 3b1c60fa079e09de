// SPDX-License-Identifier: BSD-3-Clause
#include "common/pose3.hpp"

#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace slamfuse::common {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Pose3, PlacesAForwardLookingCameraOnTheRobot) {
  // Optical frame: x right, y down, z forward.
  Eigen::Matrix3d axes;
  axes << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Pose3 T_base_camera{{0.1, 0.0, 0.8}, Eigen::Quaterniond(axes)};

  EXPECT_NEAR((T_base_camera * Eigen::Vector3d(0, 0, 5) - Eigen::Vector3d(5.1, 0, 0.8)).norm(), 0.0, 1e-14);
  EXPECT_NEAR((T_base_camera * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0.1, -1, 0.8)).norm(), 0.0, 1e-14);
}

TEST(Pose3, KnowsWhenANumberIsNotFinite) {
  Pose3 pose;
  EXPECT_TRUE(pose.is_finite());
  pose.rotation.w() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(pose.is_finite());
}

TEST(ToPose2, KeepsPositionAndYawOfATiltedPose) {
  const Eigen::Quaterniond tilted = Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(-0.1, Eigen::Vector3d::UnitX());

  const Pose2 planar = to_pose2({{1, 2, 3}, tilted});

  EXPECT_EQ(planar.translation(), Eigen::Vector2d(1, 2));
  EXPECT_NEAR(planar.theta, 2.0, 1e-14);
}

TEST(Pose3FromMatrix, ReadsAPrintedMatrix) {
  Eigen::Matrix4d printed;
  printed << 0.573576, -0.0245709, 0.818783, 0.14, -0.819152, -0.0172047, 0.573318, 0.11, 0, -0.99955, -0.0299955, 0.8,
      0, 0, 0, 1;

  const auto pose = pose3_from_matrix(printed);

  ASSERT_TRUE(pose.has_value());
  EXPECT_EQ(pose->translation, Eigen::Vector3d(0.14, 0.11, 0.8));
  EXPECT_NEAR(pose->rotation.norm(), 1.0, 1e-15);
  EXPECT_NEAR((pose->rotation.toRotationMatrix() - printed.topLeftCorner<3, 3>()).norm(), 0.0, 1e-5);
}

TEST(Pose3FromMatrix, ReadsAHalfTurn) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(1, 1) = matrix(2, 2) = -1.0;

  const auto pose = pose3_from_matrix(matrix);

  ASSERT_TRUE(pose.has_value());
  EXPECT_NEAR(pose->rotation.angularDistance(Eigen::Quaterniond::Identity()), kPi, 1e-12);
}

TEST(Pose3FromMatrix, RefusesWhatIsNoRigidTransform) {
  const Eigen::Matrix4d good = Eigen::Matrix4d::Identity();
  Eigen::Matrix4d scaled = good;
  scaled(0, 0) = 1.01;
  Eigen::Matrix4d mirrored = good;
  mirrored(1, 1) = -1.0;
  Eigen::Matrix4d projective = good;
  projective(3, 0) = 0.1;
  Eigen::Matrix4d not_finite = good;
  not_finite(0, 3) = std::numeric_limits<double>::infinity();

  ASSERT_TRUE(pose3_from_matrix(good).has_value());
  EXPECT_FALSE(pose3_from_matrix(scaled).has_value());
  EXPECT_FALSE(pose3_from_matrix(mirrored).has_value());
  EXPECT_FALSE(pose3_from_matrix(projective).has_value());
  EXPECT_FALSE(pose3_from_matrix(not_finite).has_value());
  EXPECT_FALSE(pose3_from_matrix(Eigen::Matrix4d::Zero()).has_value());
}

}  // namespace
}  // namespace slamfuse::common
