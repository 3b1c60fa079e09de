// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/dead_reckoning.hpp"

#include <gtest/gtest.h>

namespace slamfuse::visual_slam {
namespace {

using common::kNanosecondsPerSecond;

common::WheelOdometry odometry(double seconds, const common::Pose2& pose) {
  common::WheelOdometry message;
  message.stamp = common::from_seconds(seconds);
  message.pose = pose;
  return message;
}

TEST(DeadReckoning, MovesTheFilterByTheWheelsBetweenTwoImages) {
  const VisualSlamOptions options;
  Ekf filter(options.filter, options.motion);
  DeadReckoning reckoning(options);
  for (int i = 0; i <= 20; ++i) reckoning.add(odometry(0.1 * i, {5.0 + 0.05 * i, 0.0, 0.0}));  // 0.5 m/s

  reckoning.predict(filter, std::nullopt, kNanosecondsPerSecond);
  EXPECT_EQ(filter.pose().x, 0.0);
  EXPECT_NEAR(reckoning.pose().x, 5.5, 1e-9);
  reckoning.predict(filter, kNanosecondsPerSecond, 2 * kNanosecondsPerSecond);
  EXPECT_NEAR(filter.pose().x, 0.5, 1e-9);
  EXPECT_NEAR(reckoning.twist().linear.x(), 0.5, 1e-9);
  EXPECT_TRUE(reckoning.reaches(kNanosecondsPerSecond / 2));
  EXPECT_FALSE(reckoning.reaches(3 * kNanosecondsPerSecond));
}

TEST(DeadReckoning, WithoutWheelsIsWhatTheFilterBelieves) {
  VisualSlamOptions options;
  options.motion.model = MotionModelKind::kConstantVelocity;
  Ekf filter(options.filter, options.motion);
  DeadReckoning reckoning(options);

  EXPECT_FALSE(reckoning.by_wheels());
  EXPECT_TRUE(reckoning.reaches(kNanosecondsPerSecond));
  reckoning.predict(filter, std::nullopt, kNanosecondsPerSecond);
  filter.correct_pose({0.3, 0.0, 0.0}, 1e-6 * Eigen::Matrix3d::Identity());
  reckoning.corrected(filter);
  EXPECT_EQ(reckoning.twist().linear, filter.twist()->linear);
  reckoning.estimated(filter);
  EXPECT_EQ(reckoning.pose().x, filter.pose().x);
}

}  // namespace
}  // namespace slamfuse::visual_slam
