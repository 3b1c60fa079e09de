// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/alignment.hpp"

#include <cstring>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "common/config.hpp"
#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

using testing::HasSubstr;

AlignmentOptions with_method(AlignmentMethod method) {
  AlignmentOptions options;
  options.method = method;
  return options;
}

double angle_error_deg(const Alignment& alignment, double degrees) {
  return std::abs(common::to_degrees(
      common::angle_difference(common::to_radians(alignment.rotation_deg), common::to_radians(degrees))));
}

class AlignKnownMap : public testing::TestWithParam<double> {};

TEST_P(AlignKnownMap, AffineRecoversAngleAndBothScalesUnderTwentyPercentOutliers) {
  const double degrees = GetParam();
  const auto laser = flat_path();
  const auto visual = visual_path(laser, stretched_map(degrees, 7.5, 6.9, 2.0, -3.0), 0.005, 0.2, 42);

  const Alignment alignment = align_trajectories(laser, visual, with_method(AlignmentMethod::kAffine));

  ASSERT_TRUE(alignment.accepted) << alignment.reason;
  EXPECT_LT(angle_error_deg(alignment, degrees), 0.2);
  EXPECT_NEAR(alignment.scale.x() / 7.5, 1.0, 0.005);
  EXPECT_NEAR(alignment.scale.y() / 6.9, 1.0, 0.005);
  EXPECT_NEAR(static_cast<double>(alignment.inliers) / static_cast<double>(alignment.pairs), 0.8, 0.06);
  EXPECT_LT(alignment.heldout_rmse, 0.08);
}

TEST_P(AlignKnownMap, SimilarityRecoversAngleAndScaleUnderTwentyPercentOutliers) {
  const double degrees = GetParam();
  const auto laser = flat_path();
  const auto visual = visual_path(laser, stretched_map(degrees, 0.243, 0.243, 2.0, -3.0), 0.1, 0.2, 43);

  const Alignment alignment = align_trajectories(laser, visual, with_method(AlignmentMethod::kSimilarity));

  ASSERT_TRUE(alignment.accepted) << alignment.reason;
  EXPECT_LT(angle_error_deg(alignment, degrees), 0.2);
  EXPECT_NEAR(alignment.scale.x() / 0.243, 1.0, 0.005);
  EXPECT_EQ(alignment.scale.x(), alignment.scale.y());
}

TEST_P(AlignKnownMap, TheDefaultMethodRecoversAngleAndBothScales) {
  const double degrees = GetParam();
  const auto laser = flat_path();
  const auto visual = visual_path(laser, stretched_map(degrees, 2.0, 1.8, 2.0, -3.0), 0.01, 0.2, 44);

  const Alignment alignment = align_trajectories(laser, visual, {});

  ASSERT_TRUE(alignment.accepted) << alignment.reason;
  EXPECT_LT(angle_error_deg(alignment, degrees), 0.2);
  EXPECT_NEAR(alignment.scale.x() / 2.0, 1.0, 0.005);
  EXPECT_NEAR(alignment.scale.y() / 1.8, 1.0, 0.005);
}

TEST_P(AlignKnownMap, Seed004RecoversACleanPathWithinItsGrid) {
  const double degrees = GetParam();
  const auto laser = flat_path();
  const auto visual = visual_path(laser, stretched_map(degrees, 7.5, 6.9, 2.0, -3.0), 0.0, 0.0, 42);

  const Alignment alignment = align_trajectories(laser, visual, with_method(AlignmentMethod::kSeed004));

  ASSERT_TRUE(alignment.accepted) << alignment.reason;
  EXPECT_LT(angle_error_deg(alignment, degrees), 1.0);
  EXPECT_NEAR(alignment.scale.x() / 7.5, 1.0, 0.03);
  EXPECT_NEAR(alignment.scale.y() / 6.9, 1.0, 0.03);
}

INSTANTIATE_TEST_SUITE_P(Angles, AlignKnownMap, testing::Values(0.0, 31.3, 90.0, -127.4, 179.8));

TEST(AlignTrajectories, MapsPosesBothWays) {
  const auto laser = flat_path();
  const auto visual = visual_path(laser, stretched_map(50.0, 2.0, 2.0, 1.0, 1.0), 0.0, 0.0, 1);

  const Alignment alignment = align_trajectories(laser, visual, {});

  ASSERT_TRUE(alignment.accepted) << alignment.reason;
  const common::Pose2 mapped = alignment.to_laser(visual[77].pose);
  EXPECT_TRUE(mapped.vector().isApprox(laser[77].pose.vector(), 1e-6));
  EXPECT_TRUE(alignment.to_visual(mapped).vector().isApprox(visual[77].pose.vector(), 1e-6));
}

TEST(AlignTrajectories, RefusesAStraightPathAndSaysSo) {
  TestNoise random(9);
  common::Trajectory2 laser;
  for (int i = 0; i < 300; ++i) {
    laser.push_back({kTestStart + i * kTestStep, {0.05 * i, 0.02 * random.normal(), 0.0}});
  }
  const auto visual = visual_path(laser, stretched_map(20.0, 2.0, 2.0, 0.0, 0.0), 0.01, 0.0, 1);
  for (const auto method :
       {AlignmentMethod::kSimilarity, AlignmentMethod::kAffine, AlignmentMethod::kSeed004, AlignmentMethod::kAuto}) {
    const Alignment alignment = align_trajectories(laser, visual, with_method(method));

    EXPECT_FALSE(alignment.accepted) << to_string(method);
    EXPECT_THAT(alignment.reason, HasSubstr("straight")) << to_string(method);
  }
}

TEST(AlignTrajectories, RefusesAPerfectlyStraightPathToo) {
  common::Trajectory2 laser;
  for (int i = 0; i < 300; ++i) laser.push_back({kTestStart + i * kTestStep, {0.05 * i, 0.0, 0.0}});

  for (const auto method : {AlignmentMethod::kSimilarity, AlignmentMethod::kAffine, AlignmentMethod::kSeed004}) {
    const Alignment alignment = align_trajectories(laser, laser, with_method(method));

    EXPECT_FALSE(alignment.accepted);
    EXPECT_THAT(alignment.reason, HasSubstr("straight"));
  }
}

/// A path that is its own half turn, of which the visual half took one half for the other: two angles explain as many
/// pairs.
TEST(AlignTrajectories, RefusesASymmetricPathThatTwoAnglesFitEquallyWell) {
  common::Trajectory2 laser;
  common::Trajectory2 visual;
  for (int i = 0; i < 400; ++i) {
    const double t = 2.0 * std::numbers::pi * i / 100.0;
    const common::Pose2 pose{4.0 * std::cos(t), 2.0 * std::sin(t), t};
    const double side = (i / 10) % 2 == 0 ? 1.0 : -1.0;
    laser.push_back({kTestStart + i * kTestStep, pose});
    visual.push_back({kTestStart + i * kTestStep, {side * pose.x, side * pose.y, pose.theta}});
  }

  const Alignment alignment = align_trajectories(laser, visual, with_method(AlignmentMethod::kSimilarity));

  EXPECT_FALSE(alignment.accepted);
  EXPECT_THAT(alignment.reason, HasSubstr("ambiguous"));
  EXPECT_LT(alignment.runner_up_ratio, 1.3);
}

TEST(AlignTrajectories, RefusesTrajectoriesOfDifferentDrives) {
  const auto laser = flat_path();
  auto visual = flat_path();
  std::reverse(visual.begin(), visual.end());
  TestNoise random(4);
  double x = 0.0;
  double y = 0.0;
  for (std::size_t i = 0; i < visual.size(); ++i) {
    x += 0.3 * random.normal();
    y += 0.3 * random.normal();
    visual[i] = {laser[i].stamp, {x, y, 0.0}};
  }

  EXPECT_FALSE(align_trajectories(laser, visual, {}).accepted);
}

TEST(AlignTrajectories, RefusesTooFewPairsShortPathsAndNoCommonTime) {
  const auto laser = flat_path();
  const auto few = flat_path(12);
  auto later = laser;
  for (auto& pose : later) pose.stamp += 1000 * common::kNanosecondsPerSecond;
  auto tiny = laser;
  for (auto& pose : tiny) {
    pose.pose.x *= 0.01;
    pose.pose.y *= 0.01;
  }

  EXPECT_THAT(align_trajectories(laser, few, {}).reason, HasSubstr("too few pairs: 12"));
  EXPECT_THAT(align_trajectories(laser, later, {}).reason, HasSubstr("no poses at common times"));
  EXPECT_THAT(align_trajectories({}, laser, {}).reason, HasSubstr("no laser trajectory"));
  EXPECT_THAT(align_trajectories(laser, {}, {}).reason, HasSubstr("no visual trajectory"));
  EXPECT_THAT(align_trajectories(tiny, laser, {}).reason, HasSubstr("too short"));
}

TEST(AlignTrajectories, RefusesPosesThatAreNotFinite) {
  const auto laser = flat_path();
  auto visual = laser;
  visual[3].pose.theta = std::numeric_limits<double>::quiet_NaN();

  EXPECT_THAT(align_trajectories(laser, visual, {}).reason, HasSubstr("visual trajectory has a pose that is not"));
  EXPECT_THAT(align_trajectories(visual, laser, {}).reason, HasSubstr("laser trajectory has a pose that is not"));
}

TEST(AlignTrajectories, AutoTakesTheAffineMapOnlyWhereItLowersTheHeldOutErrorClearly) {
  const auto laser = flat_path();
  const auto stretched = visual_path(laser, stretched_map(20.0, 2.0, 2.4, 0.0, 0.0), 0.005, 0.1, 6);
  const auto even = visual_path(laser, stretched_map(20.0, 2.0, 2.0, 0.0, 0.0), 0.005, 0.1, 6);

  EXPECT_EQ(align_trajectories(laser, stretched, {}).method, AlignmentMethod::kAffine);
  EXPECT_EQ(align_trajectories(laser, even, {}).method, AlignmentMethod::kSimilarity);
}

TEST(AlignTrajectories, AutoKeepsTheScaleOfAMetricPathThatDriftedALittle) {
  const auto laser = flat_path();
  const auto drifted = visual_path(laser, stretched_map(20.0, 1.02, 0.99, 0.5, 0.7), 0.005, 0.0, 11);
  const auto scaled = visual_path(laser, stretched_map(20.0, 1.2, 1.2, 0.5, 0.7), 0.005, 0.0, 11);

  EXPECT_EQ(align_trajectories(laser, drifted, {}, VisualScale::kMetric).method, AlignmentMethod::kRigid);
  EXPECT_EQ(align_trajectories(laser, drifted, {}, VisualScale::kMetric).scale, Eigen::Vector2d(1.0, 1.0));
  EXPECT_EQ(align_trajectories(laser, drifted, {}, VisualScale::kUnknown).method, AlignmentMethod::kAffine);
  EXPECT_EQ(align_trajectories(laser, scaled, {}, VisualScale::kMetric).method, AlignmentMethod::kSimilarity);
}

TEST(AlignTrajectories, TheForwardErrorIsThatOfAPathThatBendsOnlyAtItsEnd) {
  const auto laser = flat_path();
  auto visual = visual_path(laser, stretched_map(20.0, 1.0, 1.0, 0.5, 0.7), 0.002, 0.0, 11);
  for (std::size_t i = visual.size() * 3 / 4; i < visual.size(); ++i) visual[i].pose.x += 0.03;

  const Alignment alignment = align_trajectories(laser, visual, {}, VisualScale::kMetric);

  ASSERT_TRUE(alignment.accepted) << alignment.reason;
  EXPECT_NEAR(alignment.forward_rmse, 0.03, 0.006);
  EXPECT_LT(alignment.heldout_rmse, 0.02);
}

TEST(AlignTrajectories, GivesTheSameBytesEveryTime) {
  const auto laser = flat_path();
  const auto visual = visual_path(laser, stretched_map(20.0, 2.0, 2.4, 0.0, 0.0), 0.05, 0.3, 6);

  const Alignment a = align_trajectories(laser, visual, {});
  const Alignment b = align_trajectories(laser, visual, {});

  EXPECT_EQ(std::memcmp(a.map.linear.data(), b.map.linear.data(), sizeof(double) * 4), 0);
  EXPECT_EQ(a.heldout_rmse, b.heldout_rmse);
  EXPECT_EQ(a.covariance, b.covariance);
}

TEST(AlignTrajectories, StandingStillMostOfTheTimeDoesNotHideTheDrive) {
  common::Trajectory2 laser = flat_path();
  const common::StampedPose2 first = laser.front();
  for (int i = 1; i <= 900; ++i) laser.insert(laser.begin(), {first.stamp - i * kTestStep, first.pose});
  TestNoise random(7);
  for (common::StampedPose2& pose : laser) {
    pose.pose.x += 0.005 * random.normal();
    pose.pose.y += 0.005 * random.normal();
  }
  const auto visual = visual_path(laser, stretched_map(30.0, 2.0, 2.0, 2.0, -3.0), 0.01, 0.0, 45);

  const Alignment alignment = align_trajectories(laser, visual, {});

  ASSERT_TRUE(alignment.accepted) << alignment.reason;
  EXPECT_LT(angle_error_deg(alignment, 30.0), 0.2);
  EXPECT_NEAR(alignment.mean_scale / 2.0, 1.0, 0.005);
  EXPECT_GT(alignment.scale_sigma, 0.0);
  EXPECT_LT(std::abs(alignment.mean_scale - 2.0), 4.0 * alignment.scale_sigma);
}

TEST(AlignTrajectories, TheScaleOfAMethodWithoutCovarianceHasNoStandardDeviation) {
  const common::Trajectory2 laser = flat_path();
  const auto visual = visual_path(laser, stretched_map(30.0, 2.0, 2.0, 2.0, -3.0), 0.01, 0.0, 45);
  EXPECT_TRUE(std::isnan(align_trajectories(laser, visual, with_method(AlignmentMethod::kSeed004)).scale_sigma));
}

TEST(AlignTrajectories, CoordinatesTooLargeToSquareAreRefused) {
  for (const AlignmentMethod method : {AlignmentMethod::kAuto, AlignmentMethod::kSeed004}) {
    common::Trajectory2 laser = flat_path(100);
    for (common::StampedPose2& pose : laser) pose.pose.x *= 1e200;
    common::Trajectory2 visual = flat_path(100);
    visual[50].pose.y = -1.7e308;

    const Alignment alignment = align_trajectories(laser, visual, with_method(method));

    EXPECT_FALSE(alignment.accepted) << to_string(method);
    EXPECT_THAT(alignment.reason, testing::Not(testing::IsEmpty()));
  }
}

TEST(AlignmentOptions, AreAllInTheConfiguration) {
  AlignmentOptions options;
  const std::string yaml = common::options_to_yaml([&](common::OptionVisitor& visit) { options.describe(visit); });

  EXPECT_THAT(yaml, HasSubstr("affine_straightness_ratio: 0.2"));
}

}  // namespace
}  // namespace slamfuse::fusion
