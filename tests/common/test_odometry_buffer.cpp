// SPDX-License-Identifier: BSD-3-Clause
#include "common/odometry_buffer.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace slamfuse::common {
namespace {

constexpr Nanoseconds kSecond = kNanosecondsPerSecond;
constexpr Nanoseconds kTenth = kSecond / 10;

WheelOdometry at(Nanoseconds stamp, const Pose2& pose, double forward_speed = 0.0, double turn_rate = 0.0) {
  return {stamp, "odom0", pose, forward_speed, turn_rate};
}

TEST(OdometryBuffer, GivesNothingWhileEmptyOrBeforeItsFirstMessage) {
  OdometryBuffer buffer;
  EXPECT_TRUE(buffer.empty());
  EXPECT_FALSE(buffer.pose_at(0).has_value());

  buffer.add(at(kSecond, {}));

  EXPECT_FALSE(buffer.empty());
  EXPECT_FALSE(buffer.pose_at(kSecond - 1).has_value());
  EXPECT_TRUE(buffer.pose_at(kSecond).has_value());
}

TEST(OdometryBuffer, InterpolatesAlongTheArc) {
  OdometryBuffer buffer;
  buffer.add(at(0, {}));
  buffer.add(at(kSecond, {1.0, 1.0, std::numbers::pi / 2}));  // a quarter circle of 1 m radius

  const auto middle = buffer.pose_at(kSecond / 2);

  ASSERT_TRUE(middle.has_value());
  EXPECT_NEAR(middle->x, std::sin(std::numbers::pi / 4), 1e-12);
  EXPECT_NEAR(middle->y, 1.0 - std::cos(std::numbers::pi / 4), 1e-12);
  EXPECT_NEAR(middle->theta, std::numbers::pi / 4, 1e-12);
}

TEST(OdometryBuffer, ReturnsMessagesExactlyAtTheirStamps) {
  OdometryBuffer buffer;
  for (int i = 0; i < 20; ++i) buffer.add(at(i * kTenth, {0.1 * i, 0.2 * i, 0.01 * i}));
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(buffer.pose_at(i * kTenth)->vector(), Eigen::Vector3d(0.1 * i, 0.2 * i, 0.01 * i));
  }
}

TEST(OdometryBuffer, ExtrapolatesWithTheSpeedItWasTold) {
  OdometryBuffer buffer;
  buffer.add(at(0, {}, 2.0, 0.0));

  EXPECT_NEAR(buffer.pose_at(kTenth)->x, 0.2, 1e-12);
}

TEST(OdometryBuffer, ExtrapolatesWithItsLastTwoPosesWhereNoSpeedIsTold) {
  OdometryBuffer buffer;
  buffer.add(at(0, {}));
  EXPECT_NEAR(buffer.pose_at(kTenth)->x, 0.0, 1e-15) << "one pose tells no speed";

  buffer.add(at(kTenth, {0.1, 0.0, 0.0}));

  EXPECT_NEAR(buffer.pose_at(3 * kTenth)->x, 0.3, 1e-12);
}

TEST(OdometryBuffer, ExtrapolatesNoFartherThanAllowed) {
  OdometryBuffer buffer(10 * kSecond, kTenth);
  buffer.add(at(0, {}, 1.0, 0.0));

  EXPECT_TRUE(buffer.pose_at(kTenth).has_value());
  EXPECT_FALSE(buffer.pose_at(kTenth + 1).has_value());
}

TEST(OdometryBuffer, HasNoJumpWhereExtrapolationMeetsTheNextMessage) {
  OdometryBuffer buffer;
  const Eigen::Vector3d twist(0.4, 0.0, 0.8);
  buffer.add(at(0, {}, twist.x(), twist.z()));
  const Pose2 extrapolated = buffer.pose_at(kTenth / 2).value();

  buffer.add(at(kTenth, exp_se2(twist * 0.1), twist.x(), twist.z()));

  EXPECT_NEAR((buffer.pose_at(kTenth / 2)->vector() - extrapolated.vector()).norm(), 0.0, 1e-12);
}

TEST(OdometryBuffer, ForgetsWhatIsNewerThanAMessageThatStepsBack) {
  OdometryBuffer buffer;
  buffer.add(at(1 * kSecond, {1, 0, 0}));
  buffer.add(at(2 * kSecond, {2, 0, 0}));
  buffer.add(at(3 * kSecond, {3, 0, 0}));

  buffer.add(at(2 * kSecond, {20, 0, 0}));

  EXPECT_EQ(buffer.newest().stamp, 2 * kSecond);
  EXPECT_EQ(buffer.pose_at(2 * kSecond)->x, 20.0);
  EXPECT_NEAR(buffer.pose_at(3 * kSecond / 2)->x, 10.5, 1e-12);
  EXPECT_FALSE(buffer.pose_at(3 * kSecond).has_value());
}

TEST(OdometryBuffer, ForgetsWhatIsOlderThanItsMemory) {
  OdometryBuffer buffer(kSecond, kTenth);
  for (int i = 0; i <= 50; ++i) buffer.add(at(i * kTenth, {0.1 * i, 0, 0}));

  EXPECT_TRUE(buffer.pose_at(4 * kSecond).has_value());
  EXPECT_FALSE(buffer.pose_at(4 * kSecond - kTenth).has_value());
}

TEST(OdometryBuffer, StartsAnewAfterALongGap) {
  OdometryBuffer buffer(kSecond, kTenth);
  buffer.add(at(0, {}));
  buffer.add(at(100 * kSecond, {5, 0, 0}));

  EXPECT_FALSE(buffer.pose_at(50 * kSecond).has_value());
  EXPECT_EQ(buffer.pose_at(100 * kSecond)->x, 5.0);
}

}  // namespace
}  // namespace slamfuse::common
