// SPDX-License-Identifier: BSD-3-Clause
#include "common/pose2.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "common/angle.hpp"

namespace slamfuse::common {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(NormalizeAngle, BringsEveryAngleIntoTheHalfOpenTurn) {
  EXPECT_EQ(normalize_angle(kPi), kPi);
  EXPECT_EQ(normalize_angle(-kPi), kPi);
  EXPECT_NEAR(normalize_angle(3 * kPi + 0.1), -kPi + 0.1, 1e-14);
  EXPECT_NEAR(normalize_angle(-7.0), -7.0 + 2 * kPi, 1e-14);
  EXPECT_EQ(normalize_angle(0.0), 0.0);
  EXPECT_TRUE(std::isnan(normalize_angle(std::numeric_limits<double>::infinity())));
}

TEST(AngleDifference, TakesTheShortWayRound) {
  EXPECT_NEAR(angle_difference(to_radians(-179), to_radians(179)), to_radians(2), 1e-14);
  EXPECT_NEAR(angle_difference(to_radians(179), to_radians(-179)), to_radians(-2), 1e-14);
}

TEST(Pose2, ComposesFromRightToLeft) {
  const Pose2 quarter_turn_left{1, 2, kPi / 2};

  const Pose2 forward = quarter_turn_left * Pose2{3, 0, 0};

  EXPECT_NEAR(forward.x, 1.0, 1e-15);
  EXPECT_NEAR(forward.y, 5.0, 1e-15);
  EXPECT_NEAR(forward.theta, kPi / 2, 1e-15);
}

TEST(Pose2, WrapsTheHeadingWhereTwoTurnsPassPi) {
  EXPECT_NEAR((Pose2{0, 0, 3} * Pose2{0, 0, 3}).theta, 6 - 2 * kPi, 1e-14);
  EXPECT_EQ((Pose2{0, 0, kPi}).inverse().theta, kPi);
}

TEST(Pose2, KnowsWhenANumberIsNotFinite) {
  EXPECT_TRUE((Pose2{1, 2, 3}).is_finite());
  EXPECT_FALSE((Pose2{1, std::numeric_limits<double>::quiet_NaN(), 3}).is_finite());
  EXPECT_FALSE((Pose2{std::numeric_limits<double>::infinity(), 2, 3}).is_finite());
}

TEST(ExpSe2, DrivesAQuarterCircle) {
  const double radius = 2.0;

  const Pose2 pose = exp_se2({radius * kPi / 2, 0.0, kPi / 2});

  EXPECT_NEAR(pose.x, radius, 1e-14);
  EXPECT_NEAR(pose.y, radius, 1e-14);
  EXPECT_NEAR(pose.theta, kPi / 2, 1e-14);
}

TEST(ExpSe2, DrivesStraightWithoutATurn) {
  EXPECT_EQ(exp_se2({1.5, -0.5, 0.0}).vector(), Eigen::Vector3d(1.5, -0.5, 0.0));
}

TEST(ExpSe2, KeepsItsDigitsForSmallTurns) {
  // Sideways displacement of driving 1 m with a turn t is t / 2 to third order.
  for (const double turn : {1e-9, 0.99e-4, 1.01e-4, 1e-3}) {
    EXPECT_NEAR(exp_se2({1.0, 0.0, turn}).y / (turn / 2.0 - turn * turn * turn / 24.0), 1.0, 1e-14) << turn;
  }
}

TEST(Interpolate, TurnsTheShortWay) {
  const Pose2 middle = interpolate({0, 0, to_radians(170)}, {2, 4, to_radians(-170)}, 0.5);

  EXPECT_DOUBLE_EQ(middle.x, 1.0);
  EXPECT_DOUBLE_EQ(middle.y, 2.0);
  EXPECT_NEAR(std::abs(middle.theta), kPi, 1e-12);
}

TEST(Interpolate, GoesOnBeyondItsEnds) {
  EXPECT_NEAR(interpolate({0, 0, 0}, {1, 0, 0.1}, 2.0).theta, 0.2, 1e-15);
  EXPECT_DOUBLE_EQ(interpolate({0, 0, 0}, {1, 0, 0.1}, -1.0).x, -1.0);
}

}  // namespace
}  // namespace slamfuse::common
