// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/corrected_pose_filter.hpp"

#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

using common::PoseSource;

UncertainPose at(double x, double y, double theta, double sigma = 0.02) {
  return {{x, y, theta}, Eigen::Vector3d(sigma * sigma, sigma * sigma, 1e-4).asDiagonal()};
}

/// Where odometry stands after a metre.
const common::Pose2 kHere{1.0, 0.0, 0.0};

/// What both halves are off by together only adds to what is stated.
CorrectedPoseOptions without_shared() {
  CorrectedPoseOptions options;
  options.shared_position_sigma = options.shared_heading_sigma = 0.0;
  return options;
}

common::Nanoseconds seconds(double time) { return common::from_seconds(time); }

/// Both halves tell poses along a straight drive of `metres`, in steps of 5 cm and 0.1 s, each off by a constant.
void drive_straight(CorrectedPoseFilter& filter, double metres, const Eigen::Vector2d& laser_off,
                    const Eigen::Vector2d& visual_off) {
  for (int n = 1; n * 0.05 <= metres; ++n) {
    const common::Pose2 odometry{0.05 * n, 0.0, 0.0};
    filter.move_to(odometry, 0.0);
    filter.measure(PoseSource::kLaser, seconds(0.1 * n), at(0.05 * n + laser_off.x(), laser_off.y(), 0.0), odometry,
                   0.0);
    filter.measure(PoseSource::kVisual, seconds(0.1 * n), at(0.05 * n + visual_off.x(), visual_off.y(), 0.0), odometry,
                   0.0);
  }
}

TEST(CorrectedPoseFilter, StartsAtTheFirstPoseWithItsCovariance) {
  CorrectedPoseFilter filter(without_shared());

  const auto report = filter.measure(PoseSource::kLaser, 0, at(1.0, 2.0, 0.5), {}, 0.0);

  EXPECT_EQ(report.outcome, MeasurementOutcome::kStarted);
  EXPECT_EQ(filter.state().pose.vector(), Eigen::Vector3d(1.0, 2.0, 0.5));
  EXPECT_TRUE(filter.state().covariance.isApprox(at(0, 0, 0).covariance, 1e-12));
}

/// Successive poses of one half share the errors of its map: a thousand of them are no better than one.
TEST(CorrectedPoseFilter, StandingStillTellsNothingNew) {
  CorrectedPoseFilter filter(without_shared());

  for (int n = 0; n < 1000; ++n) filter.measure(PoseSource::kLaser, seconds(0.1 * n), at(1.0, 2.0, 0.5), {}, 0.0);

  EXPECT_GT(filter.state().covariance(0, 0), 0.79 * 0.02 * 0.02);
}

TEST(CorrectedPoseFilter, WhatBothMayBeOffByTogetherIsStated) {
  CorrectedPoseFilter filter({});
  CorrectedPoseFilter bare(without_shared());
  drive_straight(filter, 5.0, {0.0, 0.02}, {0.0, -0.02});
  drive_straight(bare, 5.0, {0.0, 0.02}, {0.0, -0.02});

  const Eigen::Matrix3d more = filter.state().covariance - bare.state().covariance;
  EXPECT_TRUE(more.isApprox(at(0, 0, 0).covariance, 1e-9));
  EXPECT_EQ(filter.state().pose.vector(), bare.state().pose.vector());
}

TEST(CorrectedPoseFilter, LiesBetweenTwoHalvesThatAreEquallySure) {
  CorrectedPoseFilter filter(without_shared());

  drive_straight(filter, 5.0, {0.0, 0.02}, {0.0, -0.02});

  EXPECT_NEAR(filter.state().pose.y, 0.0, 0.004);
  EXPECT_LT(filter.state().covariance(1, 1), 0.02 * 0.02);
}

TEST(CorrectedPoseFilter, GoesOnWithoutAStepWhenAHalfFallsSilentAndReturnsToTheOtherLater) {
  CorrectedPoseFilter filter({});
  drive_straight(filter, 5.0, {0.0, 0.02}, {0.0, -0.02});
  const double before = filter.state().pose.y;

  double step = 0.0;
  double last = before;
  for (int n = 101; n <= 500; ++n) {
    const common::Pose2 odometry{0.05 * n, 0.0, 0.0};
    filter.move_to(odometry, 0.0);
    filter.measure(PoseSource::kVisual, seconds(0.1 * n), at(0.05 * n, -0.02, 0.0), odometry, 0.0);
    step = std::max(step, std::abs(filter.state().pose.y - last));
    last = filter.state().pose.y;
  }

  EXPECT_LT(step, 0.003);
  EXPECT_NEAR(last, -0.02, 0.003);
}

/// Poses of the model itself must lie within the stated covariance as often as it says.
TEST(CorrectedPoseFilter, TheCovarianceIsThatOfTheErrorsOfItsModel) {
  CorrectedPoseOptions options = without_shared();
  options.gate = 1000.0;
  TestNoise noise(3);
  const auto draw = [&](const Eigen::Vector3d& sigma) -> Eigen::Vector3d {
    return {sigma.x() * noise.normal(), sigma.y() * noise.normal(), sigma.z() * noise.normal()};
  };
  const double share = options.map_error.random_share;
  const Eigen::Vector3d sigma(0.05, 0.05, 0.02);
  double sum = 0.0;
  int count = 0;
  for (int run = 0; run < 20; ++run) {
    CorrectedPoseFilter filter(options);
    common::Pose2 truth;
    common::Pose2 odometry;
    std::array<Eigen::Vector3d, 2> map_error{draw(std::sqrt(1.0 - share) * sigma),
                                             draw(std::sqrt(1.0 - share) * sigma)};
    for (int n = 0; n < 300; ++n) {
      const common::Pose2 step{0.05, 0.0, 0.02};
      odometry = odometry * step;
      const double position = options.drift.position_per_metre * std::sqrt(0.05);
      const double heading = std::sqrt(std::pow(options.drift.heading_per_metre, 2) * 0.05 +
                                       std::pow(options.drift.heading_per_turn, 2) * 0.02);
      const Eigen::Vector3d slip = draw({position, position, heading});
      truth = truth * step * common::Pose2{slip.x(), slip.y(), slip.z()};
      filter.move_to(odometry, 0.0);
      const double kept = std::exp(-0.05 / options.map_error.length);
      for (const PoseSource source : {PoseSource::kLaser, PoseSource::kVisual}) {
        Eigen::Vector3d& error = map_error[source == PoseSource::kLaser ? 0 : 1];
        error = kept * error + draw(std::sqrt((1.0 - kept * kept) * (1.0 - share)) * sigma);
        const Eigen::Vector3d told = truth.vector() + error + draw(std::sqrt(share) * sigma);
        const UncertainPose measured{{told.x(), told.y(), told.z()}, sigma.cwiseAbs2().asDiagonal()};
        filter.measure(source, seconds(0.1 * n), measured, odometry, 0.0);
      }
      if (n < 50) continue;
      const Eigen::Vector3d off = difference(filter.state().pose, truth);
      sum += off.dot(filter.state().covariance.ldlt().solve(off));
      ++count;
    }
  }

  EXPECT_NEAR(sum / count, 3.0, 0.6);
}

TEST(CorrectedPoseFilter, GatesOneBadPoseAndAdoptsWhatPersists) {
  CorrectedPoseFilter filter({});
  drive_straight(filter, 1.0, {0.0, 0.0}, {0.0, 0.0});
  const double before = filter.state().pose.y;

  EXPECT_EQ(filter.measure(PoseSource::kLaser, seconds(2.1), at(1.0, 0.5, 0.0), kHere, 0.0).outcome,
            MeasurementOutcome::kGated);
  EXPECT_EQ(filter.state().pose.y, before);
  MeasurementReport report;
  for (int n = 0; n < 40; ++n) {  // the visual half is silent
    report = filter.measure(PoseSource::kLaser, seconds(2.2 + 0.1 * n), at(1.0, 0.5, 0.0), kHere, 0.0);
    if (report.outcome == MeasurementOutcome::kAdopted) break;
  }

  EXPECT_EQ(report.outcome, MeasurementOutcome::kAdopted);
  EXPECT_NEAR(report.jump, 0.5, 0.01);
  EXPECT_EQ(filter.state().pose.y, 0.5);
}

TEST(CorrectedPoseFilter, OverrulesAHalfWhileTheOtherConfirmsThePose) {
  CorrectedPoseFilter filter({});
  drive_straight(filter, 1.0, {0.0, 0.0}, {0.0, 0.0});

  MeasurementReport report;
  for (int n = 1; n <= 20; ++n) {
    filter.measure(PoseSource::kVisual, seconds(2.0 + 0.1 * n), at(1.0, 0.0, 0.0), kHere, 0.0);
    report = filter.measure(PoseSource::kLaser, seconds(2.0 + 0.1 * n), at(1.0, 0.5, 0.0), kHere, 0.0);
  }

  EXPECT_EQ(report.outcome, MeasurementOutcome::kOverruled);
  EXPECT_NEAR(filter.state().pose.y, 0.0, 0.01);
}

TEST(CorrectedPoseFilter, WhatIsHeldBackIsNotAdoptedHoweverLongItTellsTheSame) {
  CorrectedPoseFilter filter({});
  drive_straight(filter, 1.0, {0.0, 0.0}, {0.0, 0.0});

  MeasurementReport report;
  for (int n = 0; n < 100; ++n) {  // the visual half is silent
    report = filter.measure(PoseSource::kLaser, seconds(2.1 + 0.1 * n), at(1.0, 0.5, 0.0), kHere, 0.0, true);
  }

  EXPECT_EQ(report.outcome, MeasurementOutcome::kOverruled);
  EXPECT_NEAR(filter.state().pose.y, 0.0, 0.01);
}

TEST(CorrectedPoseFilter, APoseHeldBackIsJudgedAndMovesNothing) {
  CorrectedPoseFilter filter({});
  drive_straight(filter, 1.0, {0.0, 0.0}, {0.0, 0.0});
  const UncertainPose before = filter.state();

  const auto near = filter.measure(PoseSource::kLaser, seconds(2.1), at(1.0, 0.05, 0.0), kHere, 0.0, true);
  const auto far = filter.measure(PoseSource::kLaser, seconds(2.2), at(1.0, 0.5, 0.0), kHere, 0.0, true);

  EXPECT_EQ(near.outcome, MeasurementOutcome::kHeldBack);
  EXPECT_TRUE(near.fits());
  EXPECT_FALSE(near.used());
  EXPECT_EQ(far.outcome, MeasurementOutcome::kGated);
  EXPECT_EQ(filter.state().pose.vector(), before.pose.vector());
  EXPECT_EQ(filter.state().covariance, before.covariance);
}

TEST(CorrectedPoseFilter, AShiftOfOneHalfsFrameMovesNoCorrectedPose) {
  CorrectedPoseFilter filter({});
  drive_straight(filter, 2.0, {0.0, 0.02}, {0.0, -0.02});
  const common::Pose2 before = filter.state().pose;

  filter.shift(PoseSource::kVisual, {0.3, -0.1, 0.05});

  EXPECT_EQ(filter.state().pose.vector(), before.vector());
  const common::Pose2 told = filter.expected(PoseSource::kVisual).pose;
  const auto report =
      filter.measure(PoseSource::kVisual, seconds(4.1), {told, at(0, 0, 0).covariance}, filter.T_odom_base(), 0.0);
  EXPECT_EQ(report.outcome, MeasurementOutcome::kFused);
  EXPECT_LT(difference(filter.state().pose, before).norm(), 1e-12);
}

TEST(CorrectedPoseFilter, AHalfThatBecomesSureIsBelievedWhereItStands) {
  CorrectedPoseFilter filter({});
  for (int n = 0; n < 10; ++n) filter.measure(PoseSource::kLaser, seconds(0.1 * n), at(0.3, 0.0, 0.0, 0.3), {}, 0.0);

  for (int n = 10; n < 20; ++n) filter.measure(PoseSource::kLaser, seconds(0.1 * n), at(0.0, 0.0, 0.0, 0.02), {}, 0.0);

  EXPECT_NEAR(filter.state().pose.x, 0.0, 0.03);
  EXPECT_LT(filter.state().covariance(0, 0), 0.04 * 0.04);
}

TEST(CorrectedPoseFilter, AHalfThatBecomesUnsureDragsNothing) {
  CorrectedPoseFilter filter({});
  for (int n = 0; n < 10; ++n) filter.measure(PoseSource::kLaser, seconds(0.1 * n), at(0.0, 0.0, 0.0, 0.02), {}, 0.0);

  for (int n = 10; n < 60; ++n) filter.measure(PoseSource::kLaser, seconds(0.1 * n), at(0.3, 0.0, 0.0, 0.5), {}, 0.0);

  EXPECT_NEAR(filter.state().pose.x, 0.0, 0.05);
}

TEST(CorrectedPoseFilter, WithoutOdometryMapErrorsMoveOnWithTime) {
  CorrectedPoseFilter filter({});
  filter.measure(PoseSource::kLaser, 0, at(0.0, 0.0, 0.0), {}, 0.0);
  filter.measure(PoseSource::kVisual, 0, at(0.04, 0.0, 0.0), {}, 0.0);

  for (int n = 1; n <= 600; ++n) {
    filter.move_to({}, 0.1);
    filter.measure(PoseSource::kVisual, seconds(0.1 * n), at(0.04, 0.0, 0.0), {}, 0.0);
  }

  EXPECT_NEAR(filter.state().pose.x, 0.04, 0.005);  // the laser has long been silent
}

TEST(CorrectedPoseFilter, KeepsItsCovariancePositiveDefiniteOverALongDrive) {
  CorrectedPoseFilter filter({});

  drive_straight(filter, 500.0, {0.01, 0.02}, {0.0, -0.02});

  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(filter.state().covariance);
  EXPECT_GT(solver.eigenvalues().minCoeff(), 0.0);
  EXPECT_TRUE(filter.state().covariance.allFinite());
}

}  // namespace
}  // namespace slamfuse::fusion
