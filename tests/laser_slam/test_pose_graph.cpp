// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/pose_graph.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

using common::Pose2;

PoseConstraint tie(int from, int to, const Pose2& measured, double information, bool loop = false) {
  return {from, to, measured, information * Eigen::Matrix3d::Identity(), loop};
}

/// The corners of a regular polygon with sides of 1 m, heading along the sides.
std::vector<Pose2> polygon(int corners) {
  std::vector<Pose2> poses{{}};
  const Pose2 side{std::cos(std::numbers::pi / corners), std::sin(std::numbers::pi / corners),
                   2.0 * std::numbers::pi / corners};
  for (int i = 1; i < corners; ++i) poses.push_back(poses.back() * side);
  return poses;
}

TEST(PoseGraph, SpreadsTheErrorOfALoop) {
  const std::vector<Pose2> truth = polygon(24);
  const Pose2 drift{0.01, -0.004, 0.01};
  std::vector<Pose2> drifted{truth[0]};
  std::vector<PoseConstraint> constraints;
  for (int i = 1; i < 24; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const Pose2 step = truth[at - 1].inverse() * truth[at] * drift;
    drifted.push_back(drifted.back() * step);
    constraints.push_back(tie(i - 1, i, step, 1e4));
  }
  constraints.push_back(tie(0, 23, truth[0].inverse() * truth[23], 1e6, true));
  const std::vector<Pose2> solved = optimise_poses(drifted, constraints, 1e3);
  ASSERT_EQ(solved.size(), truth.size());
  EXPECT_EQ(solved[0].vector(), truth[0].vector());
  EXPECT_GT(testing::distance(drifted[23], truth[23]), 0.3);
  EXPECT_LT(testing::distance(solved[23], truth[23]), 0.01);
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_LT(testing::distance(solved[i], truth[i]), 0.2);
}

TEST(PoseGraph, DoesNotFollowALoopThatIsWrong) {
  std::vector<Pose2> line;
  std::vector<PoseConstraint> constraints;
  for (int i = 0; i < 20; ++i) {
    line.push_back({0.5 * i, 0.0, 0.0});
    if (i > 0) constraints.push_back(tie(i - 1, i, {0.5, 0.0, 0.0}, 1e4));
  }
  constraints.push_back(tie(0, 19, {4.0, 3.0, 1.0}, 1e4, true));
  const std::vector<Pose2> solved = optimise_poses(line, constraints, 1.0);
  EXPECT_LT(testing::distance(solved[19], line[19]), 0.05);
}

TEST(PoseGraph, LeavesOpenWhatNothingMeasures) {
  // Along x only the weak chain tells; a constraint without information there must not pull.
  PoseConstraint corridor = tie(0, 1, {5.0, 0.0, 0.0}, 0.0);
  corridor.information(1, 1) = corridor.information(2, 2) = 1e4;
  const std::vector<Pose2> solved =
      optimise_poses({{}, {1.0, 0.1, 0.0}}, {tie(0, 1, {1.0, 0.1, 0.0}, 1.0), corridor}, 1.0);
  EXPECT_NEAR(solved[1].x, 1.0, 1e-6);
  EXPECT_NEAR(solved[1].y, 0.0, 1e-3);
}

TEST(PoseGraph, MeasuresAcrossTheHalfTurn) {
  const double turn = std::numbers::pi - 0.05;
  const std::vector<Pose2> solved =
      optimise_poses({{0.0, 0.0, turn}, {1.0, 0.0, turn}}, {tie(0, 1, {1.0, 0.0, 0.1}, 1e4)}, 1.0);
  EXPECT_NEAR(common::angle_difference(solved[1].theta, solved[0].theta), 0.1, 1e-6);
  EXPECT_LE(std::abs(solved[1].theta), std::numbers::pi);
}

TEST(PoseGraph, GivesBackWhatNeedsNoSolving) {
  EXPECT_TRUE(optimise_poses({}, {}, 1.0).empty());
  EXPECT_EQ(optimise_poses({{1.0, 2.0, 3.0}}, {}, 1.0).size(), 1u);
  EXPECT_EQ(optimise_poses({{}, {1.0, 0.0, 0.0}}, {}, 1.0)[1].x, 1.0);
}

}  // namespace
}  // namespace slamfuse::laser_slam
