// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/motion_model.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "common/angle.hpp"

namespace slamfuse::laser_slam {
namespace {

MotionModelOptions simple_options() {
  MotionModelOptions options;
  options.translation_per_metre = 0.3;
  options.translation_per_radian = 0.0;
  options.translation_base = 0.04;
  options.rotation_per_metre = 0.0;
  options.rotation_per_radian = 0.1;
  options.rotation_base = 0.02;
  return options;
}

TEST(OdometryCovariance, GrowsWithTravelAsStated) {
  Travel travel;
  travel += common::Pose2{0.06, 0.08, -0.3};
  travel += common::Pose2{0.0, 0.0, 0.3};
  EXPECT_NEAR(travel.distance, 0.1, 1e-12);
  EXPECT_NEAR(travel.turn, 0.6, 1e-12);
  const Eigen::Matrix3d covariance = odometry_covariance(travel, simple_options());
  EXPECT_NEAR(covariance(0, 0), 0.03 * 0.03 + 0.04 * 0.04, 1e-12);
  EXPECT_NEAR(covariance(1, 1), covariance(0, 0), 1e-15);
  EXPECT_NEAR(covariance(2, 2), 0.06 * 0.06 + 0.02 * 0.02, 1e-12);
  EXPECT_EQ(covariance(0, 2), 0.0);
}

TEST(PredictionCovariance, IsWiderTheLongerTheGapAndNeverZero) {
  const auto options = simple_options();
  EXPECT_GT(prediction_covariance(0.5, options)(0, 0), prediction_covariance(0.1, options)(0, 0));
  EXPECT_GT(prediction_covariance(0.0, options)(2, 2), 0.0);
  EXPECT_EQ(prediction_covariance(-0.3, options), prediction_covariance(0.3, options));
}

TEST(IsJump, ComparesWithTheSpeedLimits) {
  MotionModelOptions options;
  options.max_speed = 2.0;
  options.max_turn_rate = 3.0;
  EXPECT_FALSE(is_jump({0.19, 0.0, 0.29}, 0.1, options));
  EXPECT_TRUE(is_jump({0.21, 0.0, 0.0}, 0.1, options));
  EXPECT_TRUE(is_jump({0.0, 0.0, -0.31}, 0.1, options));
  EXPECT_FALSE(is_jump({0.05, 0.0, 0.0}, -0.4, options)) << "a stamp that steps back allows a short motion";
}

TEST(DrawPose, HasTheMeanAndCovarianceAskedFor) {
  Eigen::Matrix3d covariance;
  covariance << 0.04, 0.01, 0.0, 0.01, 0.09, -0.005, 0.0, -0.005, 0.01;
  const common::Pose2 mean{1.0, -2.0, 3.1};
  RandomStream random(5, 0);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  constexpr int kCount = 50000;
  for (int i = 0; i < kCount; ++i) {
    const common::Pose2 pose = draw_pose(mean, covariance, random);
    ASSERT_LE(std::abs(pose.theta), std::numbers::pi);
    const Eigen::Vector3d error(pose.x - mean.x, pose.y - mean.y, common::angle_difference(pose.theta, mean.theta));
    sum += error;
    moment += error * error.transpose();
  }
  EXPECT_LT((sum / kCount).cwiseAbs().maxCoeff(), 0.005);
  EXPECT_LT((moment / kCount - covariance).cwiseAbs().maxCoeff(), 0.003);
}

TEST(ToParentFrame, TurnsTheLongAxisWithThePose) {
  const Eigen::Matrix3d body = Eigen::Vector3d(0.09, 0.01, 0.02).asDiagonal();
  const Eigen::Matrix3d turned = to_parent_frame(body, {5.0, 5.0, std::numbers::pi / 2.0});
  EXPECT_NEAR(turned(0, 0), 0.01, 1e-12);
  EXPECT_NEAR(turned(1, 1), 0.09, 1e-12);
  EXPECT_NEAR(turned(2, 2), 0.02, 1e-12);
}

}  // namespace
}  // namespace slamfuse::laser_slam
