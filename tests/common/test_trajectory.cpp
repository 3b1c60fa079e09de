// SPDX-License-Identifier: BSD-3-Clause
#include "common/trajectory.hpp"

#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace slamfuse::common {
namespace {

TEST(PathLength, AddsUpTheStraightSteps) {
  EXPECT_DOUBLE_EQ(path_length({{0, {0, 0, 0}}, {1, {3, 4, 1}}, {2, {3, 4, 2}}, {3, {3, 3, 0}}}), 6.0);
  EXPECT_EQ(path_length({}), 0.0);
  EXPECT_EQ(path_length({{5, {1, 2, 3}}}), 0.0);
}

TEST(SortedByStamp, KeepsTheLastOfPosesWithOneStamp) {
  const Trajectory2 sorted = sorted_by_stamp({{20, {1, 0, 0}}, {10, {2, 0, 0}}, {20, {3, 0, 0}}, {10, {4, 0, 0}}});

  ASSERT_EQ(sorted.size(), 2u);
  EXPECT_EQ(sorted[0].stamp, 10);
  EXPECT_EQ(sorted[0].pose.x, 4.0);
  EXPECT_EQ(sorted[1].stamp, 20);
  EXPECT_EQ(sorted[1].pose.x, 3.0);
}

TEST(ToPlanar, UndoesToSpatial) {
  const Trajectory2 planar = {{7, {1, 2, 3}}, {8, {-1, -2, -3}}};

  const Trajectory2 there_and_back = to_planar(to_spatial(planar));

  ASSERT_EQ(there_and_back.size(), 2u);
  EXPECT_EQ(there_and_back[1].stamp, 8);
  EXPECT_NEAR((there_and_back[1].pose.vector() - planar[1].pose.vector()).norm(), 0.0, 1e-14);
}

class PoseAt : public testing::Test {
 protected:
  const Trajectory2 trajectory_ = {{100, {0, 0, 3.1}}, {200, {1, 2, -3.1}}, {1000, {9, 9, 0}}};
};

TEST_F(PoseAt, GivesThePoseOfAnExactStampWhateverTheGap) {
  for (const StampedPose2& pose : trajectory_) {
    const auto found = pose_at(trajectory_, pose.stamp, 0);
    ASSERT_TRUE(found.has_value()) << pose.stamp;
    EXPECT_EQ(found->vector(), pose.pose.vector());
  }
}

TEST_F(PoseAt, InterpolatesBetweenNeighboursTheShortWayRound) {
  const auto found = pose_at(trajectory_, 125, 100);

  ASSERT_TRUE(found.has_value());
  EXPECT_DOUBLE_EQ(found->x, 0.25);
  EXPECT_DOUBLE_EQ(found->y, 0.5);
  EXPECT_NEAR(found->theta, 3.1 + 0.25 * (2 * std::numbers::pi - 6.2), 1e-12);
}

TEST_F(PoseAt, NeedsBothNeighboursWithinTheGap) {
  EXPECT_TRUE(pose_at(trajectory_, 150, 50).has_value());
  EXPECT_FALSE(pose_at(trajectory_, 150, 49).has_value());
  EXPECT_FALSE(pose_at(trajectory_, 210, 100).has_value()) << "only the earlier one is near";
  EXPECT_FALSE(pose_at(trajectory_, 990, 100).has_value()) << "only the later one is near";
  EXPECT_TRUE(pose_at(trajectory_, 600, 400).has_value());
}

TEST_F(PoseAt, GivesNothingOutsideTheTrajectory) {
  EXPECT_FALSE(pose_at(trajectory_, 99, 1000).has_value());
  EXPECT_FALSE(pose_at(trajectory_, 1001, 1000).has_value());
  EXPECT_FALSE(pose_at({}, 100, 1000).has_value());
}

TEST_F(PoseAt, OfACursorIsThatOfASearchInWhateverOrder) {
  PoseCursor cursor(trajectory_, 400);
  std::minstd_rand random(1);
  for (int n = 0; n < 2000; ++n) {
    const auto stamp = static_cast<Nanoseconds>(n % 3 == 0 ? random() % 1200 : n % 1200);
    const auto searched = pose_at(trajectory_, stamp, 400);
    const auto found = cursor.at(stamp);
    ASSERT_EQ(found.has_value(), searched.has_value()) << stamp;
    if (found) {
      EXPECT_EQ(found->vector(), searched->vector()) << stamp;
    }
  }
  const Trajectory2 empty;
  EXPECT_FALSE(PoseCursor(empty, 400).at(100).has_value());
}

}  // namespace
}  // namespace slamfuse::common
