// SPDX-License-Identifier: BSD-3-Clause
#include "common/trajectory_coverage.hpp"

#include <gtest/gtest.h>

namespace slamfuse::common {
namespace {

constexpr Nanoseconds kMillisecond = 1'000'000;

/// Poses every `step` from `from` to `to`, all in [ms], both ends included.
Trajectory2 every(Nanoseconds step, Nanoseconds from, Nanoseconds to) {
  Trajectory2 trajectory;
  for (Nanoseconds t = from; t <= to; t += step) trajectory.push_back({t * kMillisecond, {}});
  return trajectory;
}

Trajectory2 joined(Trajectory2 a, const Trajectory2& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(TrajectoryCoverage, IsWholeWherePosesFollowWithinHalfASecond) {
  EXPECT_DOUBLE_EQ(trajectory_coverage(every(500, 0, 10000), every(20, 0, 10000)), 1.0);
}

TEST(TrajectoryCoverage, CountsHalfASecondAfterEachPose) {
  EXPECT_DOUBLE_EQ(trajectory_coverage(every(1000, 0, 9000), every(20, 0, 10000)), 0.5);
}

TEST(TrajectoryCoverage, CountsNothingBeforeTheFirstPose) {
  EXPECT_DOUBLE_EQ(trajectory_coverage(every(100, 4000, 10000), every(20, 0, 10000)), 0.6);
}

TEST(TrajectoryCoverage, CountsOverlappingPosesOnceAndInAnyOrder) {
  const Trajectory2 estimate = joined(every(100, 5000, 5500), joined(every(100, 0, 500), every(100, 0, 500)));
  EXPECT_DOUBLE_EQ(trajectory_coverage(estimate, every(20, 0, 10000)), 0.2);
}

TEST(TrajectoryCoverage, LeavesHolesOfTheReferenceOutOfBoth) {
  const Trajectory2 reference = joined(every(20, 0, 2000), every(20, 8000, 10000));
  EXPECT_DOUBLE_EQ(trajectory_coverage(every(100, 0, 9000), reference), (2.0 + 1.5) / 4.0);
}

TEST(TrajectoryCoverage, TakesAHoleOfExactlyATenthOfASecondAsKnown) {
  EXPECT_FALSE(is_sparse(every(100, 0, 1000)));
  EXPECT_TRUE(is_sparse(every(101, 0, 1010)));
}

TEST(TrajectoryCoverage, CountsThePosesOfASparseReference) {
  // Poses at 0 s (hit), 2 s (an estimate 0.5 s before), 4 s (0.6 s before: not), 6 s (only later ones: not).
  const Trajectory2 estimate = {
      {0, {}}, {1500 * kMillisecond, {}}, {3400 * kMillisecond, {}}, {6001 * kMillisecond, {}}};
  EXPECT_DOUBLE_EQ(trajectory_coverage(estimate, every(2000, 0, 6000)), 0.5);
}

TEST(TimeCoverage, CountsHalfASecondAfterEachPoseHoweverLongTheTime) {
  EXPECT_DOUBLE_EQ(time_coverage(every(1000, 0, 9000), 0, 10000 * kMillisecond), 0.5);
  EXPECT_NEAR(time_coverage(every(1000, 0, 9000), 0, 2000000000 * kNanosecondsPerSecond), 0.0, 1e-6);
  EXPECT_EQ(time_coverage(every(1000, 0, 9000), 0, 0), 1.0) << "one instant";
  EXPECT_EQ(time_coverage({}, 0, 1000 * kMillisecond), 0.0);
}

TEST(TrajectoryCoverage, IsZeroWithoutEstimateOrReference) {
  EXPECT_EQ(trajectory_coverage({}, every(20, 0, 1000)), 0.0);
  EXPECT_EQ(trajectory_coverage(every(20, 0, 1000), {}), 0.0);
}

}  // namespace
}  // namespace slamfuse::common
