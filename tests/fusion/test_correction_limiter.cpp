// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/correction_limiter.hpp"

#include <gtest/gtest.h>

namespace slamfuse::fusion {
namespace {

constexpr common::Nanoseconds kTick = common::kNanosecondsPerSecond / 20;

UncertainPose at(double x, double theta = 0.0) { return {{x, 0.0, theta}, 1e-4 * Eigen::Matrix3d::Identity()}; }

TEST(CorrectionLimiter, MakesSmallCorrectionsAtOnce) {
  CorrectionLimiter limiter({});
  limiter.follow(0, at(0.0), {});

  EXPECT_EQ(limiter.follow(0, at(0.04, 0.03), {}).pose.vector(), Eigen::Vector3d(0.04, 0.0, 0.03));
  EXPECT_EQ(limiter.lag(), 0.0);
}

TEST(CorrectionLimiter, SpreadsLargeOnesOverTimeAndTellsWhatIsMissing) {
  CorrectionLimiter limiter({.speed = 0.5});
  limiter.follow(0, at(0.0), {});

  const UncertainPose next = limiter.follow(kTick, at(0.5), {});

  EXPECT_NEAR(next.pose.x, 0.025, 1e-12);
  EXPECT_NEAR(limiter.lag(), 0.475, 1e-12);
  EXPECT_NEAR(next.covariance(0, 0), 1e-4 + 0.475 * 0.475, 1e-12);
}

TEST(CorrectionLimiter, CompletesHugeOnesWithinTheSettlingTime) {
  CorrectionLimiter limiter({.speed = 0.5, .settling_time = 2.0});
  limiter.follow(0, at(0.0), {});
  double before = 0.0;

  for (int tick = 1; tick <= 40; ++tick) {
    const double x = limiter.follow(tick * kTick, at(20.0), {}).pose.x;
    EXPECT_LE(x - before, 0.5 + 1e-9);
    before = x;
  }

  EXPECT_NEAR(before, 20.0, 1e-9);
}

TEST(CorrectionLimiter, FollowsOdometryInFull) {
  CorrectionLimiter limiter({});
  limiter.follow(0, at(0.0), {});

  EXPECT_NEAR(limiter.follow(kTick, at(3.0), {3.0, 0.0, 0.0}).pose.x, 3.0, 1e-12);
}

TEST(CorrectionLimiter, StartsAnewWithoutATransition) {
  CorrectionLimiter limiter({});
  limiter.follow(0, at(0.0), {});
  limiter.restart();

  EXPECT_EQ(limiter.follow(kTick, at(9.0), {}).pose.x, 9.0);
}

}  // namespace
}  // namespace slamfuse::fusion
