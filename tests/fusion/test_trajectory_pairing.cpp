// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/trajectory_pairing.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace slamfuse::fusion {
namespace {

constexpr common::Nanoseconds kSecond = common::kNanosecondsPerSecond;

common::Trajectory2 line(common::Nanoseconds start, common::Nanoseconds step, int count) {
  common::Trajectory2 path;
  for (int i = 0; i < count; ++i) {
    const common::Nanoseconds stamp = start + i * step;
    path.push_back({stamp, {common::to_seconds(stamp), 0.0, 0.0}});
  }
  return path;
}

TEST(PairTrajectories, InterpolatesTheDenserAtTheStampsOfTheSparser) {
  const auto laser = line(0, kSecond / 10, 41);
  const auto visual = line(kSecond / 20, kSecond / 4, 12);

  const auto pairs = pair_trajectories(laser, visual, {});

  ASSERT_EQ(pairs.size(), 12u);
  for (const PosePair& pair : pairs) {
    EXPECT_NEAR(pair.laser.x, common::to_seconds(pair.stamp), 1e-12);
    EXPECT_EQ(pair.visual.x, common::to_seconds(pair.stamp));
  }
}

TEST(PairTrajectories, TakesTheLasersStampsWhereTheLaserIsSparser) {
  const auto pairs = pair_trajectories(line(0, kSecond / 4, 5), line(0, kSecond / 10, 11), {});

  ASSERT_EQ(pairs.size(), 5u);
  EXPECT_EQ(pairs[1].stamp, kSecond / 4);
}

TEST(PairTrajectories, MakesNoPairAcrossAHoleWiderThanTheGap) {
  auto laser = line(0, kSecond / 10, 101);
  laser.erase(laser.begin() + 30, laser.begin() + 70);
  const auto visual = line(kSecond / 20, kSecond / 5, 45);

  const auto pairs = pair_trajectories(laser, visual, {.max_gap = 0.5});

  for (const PosePair& pair : pairs) {
    EXPECT_TRUE(pair.stamp < 3 * kSecond || pair.stamp > 7 * kSecond - kSecond / 10) << pair.stamp;
  }
}

TEST(PairTrajectories, SortsStampsThatStepBackAndLeavesOutPosesThatAreNotFinite) {
  auto laser = line(0, kSecond / 10, 21);
  std::swap(laser[3], laser[4]);
  auto visual = line(0, kSecond / 5, 11);
  visual[5].pose.x = std::numeric_limits<double>::quiet_NaN();

  const auto pairs = pair_trajectories(laser, visual, {});

  ASSERT_EQ(pairs.size(), 10u);
  for (std::size_t i = 1; i < pairs.size(); ++i) EXPECT_GT(pairs[i].stamp, pairs[i - 1].stamp);
}

TEST(PairTrajectories, GivesNothingWithoutCommonTime) {
  EXPECT_TRUE(pair_trajectories(line(0, kSecond, 5), line(100 * kSecond, kSecond, 5), {}).empty());
  EXPECT_TRUE(pair_trajectories({}, line(0, kSecond, 5), {}).empty());
}

TEST(WithoutStandstill, KeepsOnePairOfAStandAndEveryPairOfADrive) {
  std::vector<PosePair> pairs;
  for (const double x : {0.0, 0.01, 0.0, 0.015, 0.05, 0.10, 0.11, 0.15}) pairs.push_back({0, {x, 0, 0}, {}});
  PairingOptions options;
  options.min_step = 0.02;

  const auto moving = without_standstill(pairs, options);

  ASSERT_EQ(moving.size(), 4u);
  EXPECT_EQ(moving[1].laser.x, 0.05);
  EXPECT_EQ(moving[3].laser.x, 0.15);
  EXPECT_TRUE(without_standstill({}, options).empty());
}

}  // namespace
}  // namespace slamfuse::fusion
