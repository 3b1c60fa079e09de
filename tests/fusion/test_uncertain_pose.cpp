// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/uncertain_pose.hpp"

#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

namespace slamfuse::fusion {
namespace {

UncertainPose pose(double x, double y, double theta, double vx, double vy, double vtheta) {
  return {{x, y, theta}, Eigen::Vector3d(vx, vy, vtheta).asDiagonal()};
}

TEST(Intersect, TakesTheMoreCertainOneWhereItIsMoreCertainInEveryDirection) {
  const UncertainPose vague = pose(1.0, 2.0, 0.3, 1.0, 1.0, 1.0);
  const UncertainPose sharp = pose(1.5, 2.5, 0.1, 0.1, 0.2, 0.3);

  EXPECT_EQ(intersect(vague, sharp).pose.vector(), sharp.pose.vector());
  EXPECT_EQ(intersect(sharp, vague).pose.vector(), sharp.pose.vector());
  EXPECT_EQ(intersect(vague, sharp).covariance, sharp.covariance);
}

TEST(Intersect, TakesEachDirectionFromWhoeverKnowsIt) {
  const UncertainPose across = pose(0.0, 0.0, 0.0, 1.0, 1e-4, 1e-3);  // a corridor along x: x unknown
  const UncertainPose along = pose(1.0, 1.0, 0.0, 1e-4, 1.0, 1e-3);

  const UncertainPose fused = intersect(across, along);

  EXPECT_NEAR(fused.pose.x, 1.0, 0.01);
  EXPECT_NEAR(fused.pose.y, 0.0, 0.01);
}

TEST(Intersect, IsNeverMoreCertainThanBothAllowWhateverTheirCorrelation) {
  const UncertainPose a = pose(0.0, 0.0, 0.0, 0.5, 0.02, 0.1);
  const UncertainPose b = pose(0.1, 0.1, 0.1, 0.03, 0.4, 0.2);

  const UncertainPose fused = intersect(a, b);
  const UncertainPose twice = intersect(a, a);

  // Counting the same pose twice gains nothing.
  EXPECT_TRUE(twice.covariance.isApprox(a.covariance, 1e-12));
  // As independent, the variances would be below each of both divided by about one; as unknown they lie above.
  EXPECT_GT(fused.covariance(0, 0), 1.0 / (1.0 / 0.5 + 1.0 / 0.03));
  EXPECT_GT(fused.covariance(1, 1), 1.0 / (1.0 / 0.02 + 1.0 / 0.4));
}

TEST(Intersect, TurnsTheShortWayRound) {
  const UncertainPose a = pose(0.0, 0.0, std::numbers::pi - 0.01, 1.0, 0.1, 0.1);
  const UncertainPose b = pose(0.0, 0.0, -std::numbers::pi + 0.01, 0.1, 1.0, 0.1);

  EXPECT_NEAR(std::abs(intersect(a, b).pose.theta), std::numbers::pi, 0.011);
}

TEST(SquaredDistance, IsOneForAnErrorOfOneStandardDeviation) {
  EXPECT_NEAR(squared_distance(pose(1.0, 0, 0, 0.5, 1, 1), pose(0.0, 0, 0, 0.5, 1, 1)), 1.0, 1e-12);
  EXPECT_NEAR(squared_distance(pose(0, 0, 3.1, 1, 1, 0.01), pose(0, 0, -3.1, 1, 1, 0.01)),
              std::pow(2.0 * std::numbers::pi - 6.2, 2) / 0.02, 1e-9);
}

}  // namespace
}  // namespace slamfuse::fusion
