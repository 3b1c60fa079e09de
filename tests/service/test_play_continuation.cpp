// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "service/play_command.hpp"

namespace slamfuse::service {
namespace {

constexpr common::Nanoseconds kSecond = 1'000'000'000;

common::WheelOdometry odometry_at(common::Nanoseconds stamp, double x) {
  return {stamp, "odom0", {x, 0.0, 0.0}, 0.5, 0.0};
}

TEST(Continuation, LeavesTheFirstTurnAsItIs) {
  Continuation continuation;
  const auto message = continuation.next(odometry_at(5 * kSecond, 3.0));
  EXPECT_EQ(common::stamp_of(message), 5 * kSecond);
  EXPECT_EQ(std::get<common::WheelOdometry>(message).pose.x, 3.0);
}

TEST(Continuation, StampsAndOdometryGoOn) {
  Continuation continuation;
  continuation.next(odometry_at(5 * kSecond, 3.0));
  continuation.next(common::LaserScan{9 * kSecond, "laser0", {}});
  continuation.next(odometry_at(8 * kSecond, 4.0));
  continuation.again();
  const auto scan = continuation.next(common::LaserScan{5 * kSecond, "laser0", {}});
  EXPECT_EQ(common::stamp_of(scan), 10 * kSecond);
  const auto first = std::get<common::WheelOdometry>(continuation.next(odometry_at(6 * kSecond, 3.0)));
  EXPECT_EQ(first.stamp, 11 * kSecond);
  EXPECT_EQ(first.pose.x, 4.0);
  const auto second = std::get<common::WheelOdometry>(continuation.next(odometry_at(7 * kSecond, 3.5)));
  EXPECT_EQ(second.pose.x, 4.5);
}

}  // namespace
}  // namespace slamfuse::service
