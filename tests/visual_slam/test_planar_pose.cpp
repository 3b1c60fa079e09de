// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/planar_pose.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "common/angle.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;

/// The landmark as seen without error from a pose by a camera at `origin`.
Sight seen(const Eigen::Vector3d& landmark, const Pose2& pose, const Eigen::Vector3d& origin) {
  Sight sight{.origin = origin, .landmark = landmark};
  sight.ray = line_of_sight(sight, pose).normalized();
  return sight;
}

void expect_near(const Pose2& a, const Pose2& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(common::normalize_angle(a.theta - b.theta), 0.0, tolerance);
}

Pose2 random_pose(testing::Noise& noise) {
  return {4.0 * noise.uniform() - 2.0, 3.0 * noise.uniform() - 1.5, 2.0 * std::numbers::pi * (noise.uniform() - 0.5)};
}

TEST(PlanarPose, IsTheOneFromWhichTwoLandmarksAreSeenByTwoCameras) {
  testing::Noise noise(1);
  const std::vector<Eigen::Vector3d> points = testing::room_points(40, noise);
  int solved = 0;
  for (std::size_t i = 0; i + 1 < points.size(); i += 2) {
    const Pose2 truth = random_pose(noise);
    const Sight a = seen(points[i], truth, {0.1, 0.1, 0.7}), b = seen(points[i + 1], truth, {0.1, -0.1, 0.7});

    const std::optional<Pose2> pose = pose_from_two_sights(a, b);

    ASSERT_TRUE(pose) << i;
    // Two sights may fit a second pose as well; the one found always explains them.
    EXPECT_LT(sight_error(a, *pose), 1e-3);
    EXPECT_LT(sight_error(b, *pose), 1e-3);
    solved += (pose->translation() - truth.translation()).norm() < 1e-2 ? 1 : 0;
  }
  EXPECT_GE(solved, 18) << "of 20";
}

TEST(PlanarPose, IsNotFoundFromSightsThatContradictEachOther) {
  const Pose2 truth{0.5, -0.3, 0.4};
  const Sight a = seen({3.0, 1.0, 1.5}, truth, {0.1, 0.0, 0.7});
  Sight b = seen({3.0, 1.5, 1.5}, truth, {0.1, 0.0, 0.7});
  b.ray = Eigen::Vector3d(-b.ray.x(), 0.2, -b.ray.z()).normalized();

  EXPECT_FALSE(pose_from_two_sights(a, b));
}

TEST(PlanarPose, ALandmarkBehindIsInfinitelyWrong) {
  const Sight sight = seen({3.0, 0.0, 1.0}, {}, {0.0, 0.0, 0.7});

  EXPECT_LT(sight_error(sight, {}), 1e-12);
  EXPECT_TRUE(std::isinf(sight_error(sight, {6.0, 0.0, 0.0})));
}

TEST(PlanarPose, RefinementUsesAllSightsAndKnowsItsError) {
  testing::Noise noise(2);
  constexpr double kSigma = 0.003;
  double squared = 0.0;
  constexpr int kRuns = 100;
  for (int run = 0; run < kRuns; ++run) {
    const Pose2 truth = random_pose(noise);
    std::vector<Sight> sights;
    for (const Eigen::Vector3d& point : testing::room_points(20, noise)) {
      Sight sight = seen(point, truth, {0.1, 0.1, 0.7});
      for (int i = 0; i < 3; ++i) sight.ray[i] += kSigma * noise.gaussian();
      sight.ray.normalize();
      sights.push_back(sight);
    }

    const std::optional<RefinedPose> refined =
        refine_pose(sights, {truth.x + 0.2, truth.y - 0.2, truth.theta + 0.1}, kSigma);

    ASSERT_TRUE(refined);
    expect_near(refined->pose, truth, 0.05);
    const Eigen::Vector3d error(refined->pose.x - truth.x, refined->pose.y - truth.y,
                                common::normalize_angle(refined->pose.theta - truth.theta));
    squared += error.dot(refined->covariance.inverse() * error);
  }
  EXPECT_NEAR(squared / kRuns, 3.0, 0.8);
}

TEST(PlanarPose, OneSightDoesNotDetermineIt) {
  const Sight one[] = {seen({3.0, 0.0, 1.0}, {}, {0.0, 0.0, 0.7})};

  const std::optional<RefinedPose> refined = refine_pose(one, {}, 0.003);

  EXPECT_TRUE(!refined || !(refined->covariance.trace() < 1.0));
}

}  // namespace
}  // namespace slamfuse::visual_slam
