// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/bend_tracker.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

constexpr double kGate = 16.27;

Eigen::Matrix3d variances(double position, double heading) {
  return Eigen::Vector3d(position * position, position * position, heading * heading).asDiagonal();
}

TEST(BendTracker, SettlesOnABendThatDoesNotChange) {
  BendTracker tracker({.length = 5.0});
  tracker.restart(variances(0.1, 0.05));
  TestNoise noise(1);

  for (int n = 0; n < 100; ++n) {
    tracker.move(0.05);
    tracker.update({0.12 + 0.02 * noise.normal(), -0.06 + 0.02 * noise.normal(), 0.03}, variances(0.02, 0.01), kGate);
  }

  EXPECT_NEAR(tracker.bend().x(), 0.12, 0.015);
  EXPECT_NEAR(tracker.bend().y(), -0.06, 0.015);
  EXPECT_NEAR(tracker.bend().z(), 0.03, 0.005);
  EXPECT_LT(tracker.covariance()(0, 0), 0.02 * 0.02);
}

TEST(BendTracker, IsForgottenOverTheDistanceDriven) {
  BendTracker tracker({.length = 5.0});
  tracker.restart(variances(0.1, 0.05));
  tracker.update({0.1, 0.0, 0.0}, variances(0.001, 0.001), kGate);

  tracker.move(5.0);
  EXPECT_NEAR(tracker.bend().x(), 0.1 / std::exp(1.0), 1e-4);
  tracker.move(100.0);

  EXPECT_NEAR(tracker.bend().x(), 0.0, 1e-6);
  EXPECT_TRUE(tracker.covariance().isApprox(variances(0.1, 0.05), 1e-6));
}

/// Residuals of the model itself must lie within the covariance as often as it says.
TEST(BendTracker, ItsCovarianceIsThatOfItsErrors) {
  TestNoise noise(2);
  const double kept = std::exp(-0.1 / 5.0);
  BendTracker tracker({.length = 5.0});
  tracker.restart(variances(0.1, 0.05));
  Eigen::Vector3d truth(0.1 * noise.normal(), 0.1 * noise.normal(), 0.05 * noise.normal());
  double sum = 0.0;
  constexpr int kSteps = 4000;
  for (int n = 0; n < kSteps; ++n) {
    const Eigen::Vector3d fresh(0.1 * noise.normal(), 0.1 * noise.normal(), 0.05 * noise.normal());
    truth = kept * truth + std::sqrt(1.0 - kept * kept) * fresh;
    tracker.move(0.1);
    const Eigen::Vector3d told =
        truth + Eigen::Vector3d(0.03 * noise.normal(), 0.03 * noise.normal(), 0.01 * noise.normal());
    EXPECT_TRUE(tracker.update(told, variances(0.03, 0.01), 100.0));
    const Eigen::Vector3d error = tracker.bend() - truth;
    sum += error.dot(tracker.covariance().ldlt().solve(error));
  }

  EXPECT_NEAR(sum / kSteps, 3.0, 0.3);
}

TEST(BendTracker, FollowsAStepOfOneMapAtOnce) {
  BendTracker tracker({.length = 5.0});
  tracker.restart(variances(0.2, 0.05));
  for (int n = 0; n < 50; ++n) tracker.update({0.0, 0.0, 0.0}, variances(0.02, 0.01), kGate);

  EXPECT_TRUE(tracker.update({0.3, 0.0, 0.0}, variances(0.02, 0.01), kGate));

  EXPECT_NEAR(tracker.bend().x(), 0.3, 0.02);
}

TEST(BendTracker, TakesNoResidualThatNoBendExplains) {
  BendTracker tracker({.length = 5.0});
  tracker.restart(variances(0.1, 0.05));
  tracker.update({0.05, 0.0, 0.0}, variances(0.02, 0.01), kGate);
  const Eigen::Vector3d before = tracker.bend();
  const Eigen::Matrix3d covariance = tracker.covariance();

  EXPECT_FALSE(tracker.update({4.0, 0.0, 0.0}, variances(0.02, 0.01), kGate));

  EXPECT_EQ(tracker.bend(), before);
  EXPECT_EQ(tracker.covariance(), covariance);
}

TEST(BendTracker, ANewAlignmentMovesNoCorrectedPose) {
  BendTracker tracker({.length = 5.0});
  tracker.restart(variances(0.1, 0.05));
  tracker.update({0.05, 0.02, 0.01}, variances(0.02, 0.01), kGate);
  const common::Pose2 by_old{3.0, 4.0, 3.14};
  const common::Pose2 by_new{3.1, 3.8, -3.12};
  const UncertainPose before = tracker.correct({by_old, variances(0.02, 0.01)});

  tracker.realign(difference(by_new, by_old), variances(0.1, 0.05));

  const UncertainPose after = tracker.correct({by_new, variances(0.02, 0.01)});
  EXPECT_LT(difference(after.pose, before.pose).norm(), 1e-12);
}

}  // namespace
}  // namespace slamfuse::fusion
