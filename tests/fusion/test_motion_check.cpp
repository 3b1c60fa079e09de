// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/motion_check.hpp"

#include <gtest/gtest.h>

namespace slamfuse::fusion {
namespace {

UncertainPose at(const common::Pose2& pose) { return {pose, Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal()}; }

common::Nanoseconds seconds(double time) { return common::from_seconds(time); }

/// Drives for two seconds at half a metre a second; what the half says of each step is `told`.
MotionCheck after_two_seconds(const common::Pose2& told) {
  MotionCheck check({}, {});
  common::Pose2 odometry{1.0, 2.0, 0.3};
  common::Pose2 half{-4.0, 0.5, 2.0};
  for (int n = 0; n <= 20; ++n) {
    check.add(seconds(0.1 * n), at(half), 1.0, odometry);
    odometry = odometry * common::Pose2{0.05, 0.0, 0.0};
    half = half * told;
  }
  return check;
}

TEST(MotionCheck, TellsNothingBeforeAWindowHasPassed) {
  MotionCheck check({}, {});
  check.add(seconds(0.0), at({}), 1.0, {});
  check.add(seconds(0.9), at({5.0, 0.0, 0.0}), 1.0, {});

  EXPECT_EQ(check.plausible(seconds(0.9)), std::nullopt);
}

TEST(MotionCheck, AHalfMayMoveAsTheWheelsDoInAnotherFrame) {
  EXPECT_EQ(after_two_seconds({0.05, 0.0, 0.0}).plausible(seconds(2.0)), true);
  EXPECT_EQ(after_two_seconds({0.047, 0.001, 0.001}).plausible(seconds(2.0)), true);
}

TEST(MotionCheck, MeasuresInMetresWhateverTheUnit) {
  MotionCheck check({}, {});
  for (int n = 0; n <= 20; ++n) check.add(seconds(0.1 * n), at({0.02 * n, 0.0, 0.0}), 2.5, {0.05 * n, 0.0, 0.0});

  EXPECT_TRUE(check.confirms(seconds(2.0)));
}

TEST(MotionCheck, AHalfThatStandsOrTurnsWhileTheWheelsDriveIsNotPlausible) {
  EXPECT_EQ(after_two_seconds({0.0, 0.0, 0.0}).plausible(seconds(2.0)), false);
  EXPECT_EQ(after_two_seconds({0.05, 0.0, -0.02}).plausible(seconds(2.0)), false);
}

TEST(MotionCheck, WhatWasSaidLongAgoTellsNothing) {
  EXPECT_EQ(after_two_seconds({0.0, 0.0, 0.0}).plausible(seconds(4.0)), std::nullopt);
}

TEST(MotionCheck, ForgetsOnRequestAndAfterASilence) {
  MotionCheck told_anew = after_two_seconds({0.0, 0.0, 0.0});
  told_anew.forget();
  EXPECT_EQ(told_anew.plausible(seconds(2.0)), std::nullopt);

  MotionCheck silent = after_two_seconds({0.0, 0.0, 0.0});
  silent.add(seconds(3.5), at({}), 1.0, {});
  EXPECT_EQ(silent.plausible(seconds(3.5)), std::nullopt);
}

TEST(MotionCheck, OnlyAHalfThatCouldTellIsAWitness) {
  EXPECT_TRUE(after_two_seconds({0.05, 0.0, 0.0}).confirms(seconds(2.0)));
  EXPECT_FALSE(after_two_seconds({0.0, 0.0, 0.0}).confirms(seconds(2.0)));

  MotionCheck vague({}, {});
  MotionCheck standing({}, {});
  for (int n = 0; n <= 20; ++n) {
    const common::Pose2 pose{0.05 * n, 0.0, 0.0};
    vague.add(seconds(0.1 * n), {pose, Eigen::Vector3d(0.25, 0.25, 0.1).asDiagonal()}, 1.0, pose);
    standing.add(seconds(0.1 * n), at({}), 1.0, {});
  }
  EXPECT_FALSE(vague.confirms(seconds(2.0)));
  EXPECT_FALSE(standing.confirms(seconds(2.0)));
}

TEST(MotionCheck, HoldsNoMoreWhereStampsStandStill) {
  MotionCheck check({}, {});
  for (int n = 0; n < 1000; ++n) check.add(seconds(1.0), at({0.1 * n, 0.0, 0.0}), 1.0, {});

  EXPECT_EQ(check.plausible(seconds(1.0)), std::nullopt);
}

}  // namespace
}  // namespace slamfuse::fusion
