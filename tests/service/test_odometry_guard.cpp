// SPDX-License-Identifier: BSD-3-Clause
#include "service/odometry_guard.hpp"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr common::Nanoseconds kStart = 1'700'000'000'000'000'000;
constexpr common::Nanoseconds kPeriod = 50'000'000;
const OdometryGuard::Arrival kArrival = OdometryGuard::Arrival() + 1h;

common::WheelOdometry odometry(int message, double x, double theta = 0.0) {
  return {kStart + message * kPeriod, "odom0", {x, 0.0, theta}, 0.5, 0.0};
}
OdometryGuard::Arrival arrival(int message) { return kArrival + message * 50ms; }

/// A guard that has heard a robot drive 0.5 m/s from 0 to message 9.
OdometryGuard driven() {
  OdometryGuard guard{OdometryLimits{}};
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(guard.flaw_of(odometry(i, 0.025 * i), arrival(i)));
  return guard;
}

TEST(OdometryGuard, NamesAJumpAndGoesOnWithTheRest) {
  OdometryGuard guard = driven();
  const auto jump = guard.flaw_of(odometry(10, 5.0), arrival(10));
  ASSERT_TRUE(jump);
  EXPECT_THAT(*jump, HasSubstr("odometry jumps by 4.78 m in 0.05 s (allowed: 5 m/s, service.odometry.speed)"));
  EXPECT_FALSE(guard.flaw_of(odometry(11, 0.275), arrival(11)));
}

TEST(OdometryGuard, NamesATurnThatIsTooFast) {
  OdometryGuard guard = driven();
  const auto turn = guard.flaw_of(odometry(10, 0.25, 2.0), arrival(10));
  ASSERT_TRUE(turn);
  EXPECT_THAT(*turn, HasSubstr("odometry turns by 2 rad in 0.05 s"));
  EXPECT_FALSE(guard.flaw_of(odometry(11, 0.275, 0.5), arrival(11)));
}

TEST(OdometryGuard, NamesSpeedsThatNoRobotHas) {
  OdometryGuard guard{OdometryLimits{}};
  common::WheelOdometry fast = odometry(0, 0.0);
  fast.forward_speed = -1e30;
  EXPECT_THAT(guard.flaw_of(fast, arrival(0)).value_or(""), HasSubstr("drives -1e+30 m/s"));
  fast.forward_speed = 0.0;
  fast.turn_rate = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(guard.flaw_of(fast, arrival(0)).value_or(""), HasSubstr("turns at nan rad/s"));
}

TEST(OdometryGuard, AcceptsADriverThatWasStartedAgainAfterASecond) {
  OdometryGuard guard = driven();
  int refused = 0;
  int message = 10;
  while (guard.flaw_of(odometry(message, 20.0 + 0.025 * message), arrival(message)) && refused < 100) {
    ++refused;
    ++message;
  }
  EXPECT_EQ(refused, 20);
  EXPECT_FALSE(guard.flaw_of(odometry(message + 1, 20.0 + 0.025 * message), arrival(message + 1)));
}

TEST(OdometryGuard, ForgedPosesBetweenTheTrueOnesNeverGetThrough) {
  OdometryGuard guard = driven();
  for (int i = 10; i < 400; i += 2) {
    EXPECT_TRUE(guard.flaw_of(odometry(i, 30.0), arrival(i)));
    EXPECT_FALSE(guard.flaw_of(odometry(i + 1, 0.025 * (i + 1)), arrival(i + 1)));
  }
}

TEST(OdometryGuard, ALongSilenceAllowsALongWay) {
  OdometryGuard guard = driven();
  EXPECT_FALSE(guard.flaw_of(odometry(10 + 20 * 10, 40.0, 3.0), arrival(210)));
}

TEST(OdometryGuard, LeavesStampsToOthers) {
  OdometryGuard guard = driven();
  EXPECT_FALSE(guard.flaw_of(odometry(5, 50.0), arrival(10)));
  EXPECT_FALSE(guard.flaw_of(odometry(11, 0.275), arrival(11)));
}

}  // namespace
}  // namespace slamfuse::service
