// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/odometry_clock.hpp"

#include <gtest/gtest.h>

namespace slamfuse::fusion {
namespace {

common::Nanoseconds seconds(double time) { return common::from_seconds(time); }

/// Ten messages a second, each followed by a pose of its time.
OdometryClock ten_a_second() {
  OdometryClock clock;
  for (int n = 0; n <= 20; ++n) {
    EXPECT_EQ(clock.next(seconds(0.1 * n)), 0);
    clock.heard(seconds(0.1 * n));
  }
  return clock;
}

TEST(OdometryClock, APauseOfAllInputDoesNotCount) {
  OdometryClock clock = ten_a_second();

  EXPECT_EQ(clock.next(seconds(3.5)), seconds(1.5));
}

TEST(OdometryClock, APauseInWhichAHalfSpokeIsNone) {
  OdometryClock clock = ten_a_second();

  clock.heard(seconds(3.0));
  EXPECT_EQ(clock.next(seconds(3.5)), 0);
}

TEST(OdometryClock, ALongPauseCounts) {
  OdometryClock clock = ten_a_second();

  EXPECT_EQ(clock.next(seconds(8.0)), 0);
}

/// Else halves that died would never be missed.
TEST(OdometryClock, OnlyOnePauseUntilAHalfSpeaksAgain) {
  OdometryClock clock = ten_a_second();
  EXPECT_GT(clock.next(seconds(3.5)), 0);
  EXPECT_EQ(clock.next(seconds(5.0)), 0);

  clock.heard(seconds(5.0));
  EXPECT_GT(clock.next(seconds(6.5)), 0);
}

TEST(OdometryClock, SlowOdometryIsNoPause) {
  OdometryClock clock;
  for (int n = 0; n <= 20; ++n) EXPECT_EQ(clock.next(seconds(0.5 * n)), 0);
}

TEST(OdometryClock, AStepBackTakesEverythingAlong) {
  OdometryClock clock = ten_a_second();

  EXPECT_EQ(clock.next(seconds(-598.0)), seconds(-600.0));
  EXPECT_EQ(clock.next(seconds(-597.9)), 0);
}

}  // namespace
}  // namespace slamfuse::fusion
