// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/scan_matcher.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "laser_slam/degeneracy.hpp"
#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

constexpr double kGain = 0.1;

ScanBeams beams_at(const testing::Walls& walls, const common::LaserCalibration& laser, const common::Pose2& pose,
                   RandomStream& noise) {
  return *project_scan(testing::scan_at(walls, laser, 0, pose, &noise), laser, {}, Eigen::Vector3d::Zero());
}

/// A map of the walls drawn from a few poses near the origin, with 1 cm of range noise.
GridMap map_of(const testing::Walls& walls, const common::LaserCalibration& laser, RandomStream& noise) {
  GridMap map{MapOptions{}};
  InsertionScratch scratch;
  for (int i = 0; i < 8; ++i) {
    const common::Pose2 pose{0.05 * i, 0.02 * i, 0.03 * i};
    map.insert(beams_at(walls, laser, pose, noise), pose, 0.0, scratch);
  }
  return map;
}

PosePrior vague_prior(const common::Pose2& mean) { return {mean, Eigen::Matrix3d::Zero()}; }

class ScanMatcherTest : public ::testing::Test {
 protected:
  RandomStream noise_{11, 0};
  testing::Walls walls_ = testing::room();
  common::LaserCalibration laser_ = testing::full_circle_laser(360);
  GridMap map_ = map_of(walls_, laser_, noise_);
  ScanMatcher matcher_{ScanMatcherOptions{}, kGain};
  common::Pose2 truth_{0.31, 0.12, 0.2};
  ScanBeams scan_ = beams_at(walls_, laser_, truth_, noise_);
};

TEST_F(ScanMatcherTest, RecoversAKnownOffset) {
  for (const common::Pose2& offset :
       {common::Pose2{0.06, 0.0, 0.0}, common::Pose2{-0.05, 0.05, 0.03}, common::Pose2{0.02, -0.07, -0.04}}) {
    const common::Pose2 start = truth_ * offset;
    const ScanMatch match = matcher_.match(map_, scan_.match_points, start, vague_prior(start));
    EXPECT_LT(testing::distance(match.pose, truth_), 0.005);
    EXPECT_NEAR(match.pose.theta, truth_.theta, 0.002);
    EXPECT_GT(match.fit.agreement, 0.85);
  }
}

TEST_F(ScanMatcherTest, FindsADistantPoseBySearching) {
  const ScanMatch match = matcher_.search(map_, scan_.match_points, truth_ * common::Pose2{0.5, -0.45, 0.4});
  EXPECT_LT(testing::distance(match.pose, truth_), 0.005);
  EXPECT_NEAR(match.pose.theta, truth_.theta, 0.002);
}

TEST_F(ScanMatcherTest, LikesTheTruthBetterThanPosesAroundIt) {
  const double best = matcher_.evaluate(map_, scan_.match_points, truth_).log_likelihood;
  for (int direction = 0; direction < 8; ++direction) {
    const common::Pose2 other =
        truth_ * common::Pose2{0.04 * std::cos(direction * 0.785), 0.04 * std::sin(direction * 0.785), 0.0};
    EXPECT_GT(best, matcher_.evaluate(map_, scan_.match_points, other).log_likelihood);
  }
}

TEST_F(ScanMatcherTest, HasAGradientThatPointsHome) {
  const ScanFit fit = matcher_.evaluate(map_, scan_.match_points, {truth_.x + 0.02, truth_.y, truth_.theta});
  EXPECT_LT(fit.gradient.x(), 0.0);
  EXPECT_GT(fit.information(0, 0), 0.0);
}

TEST_F(ScanMatcherTest, StaysWithAFirmPrior) {
  const common::Pose2 start = truth_ * common::Pose2{0.05, 0.0, 0.0};
  const ScanMatch match = matcher_.match(map_, scan_.match_points, start, {start, 1e9 * Eigen::Matrix3d::Identity()});
  EXPECT_LT(testing::distance(match.pose, start), 1e-4);
}

TEST_F(ScanMatcherTest, CountsUnknownSpaceNeitherForNorAgainst) {
  const ScanFit fit = matcher_.evaluate(map_, scan_.match_points, {500.0, 0.0, 0.0});
  EXPECT_EQ(fit.known, 0);
  EXPECT_EQ(fit.agreement, 0.0);
  EXPECT_NEAR(fit.log_likelihood,
              std::log(ScanMatcherOptions{}.unknown_likelihood) * static_cast<double>(scan_.match_points.size()), 1e-6);
}

TEST_F(ScanMatcherTest, ReportsTheShareOfOldSurfaces) {
  EXPECT_EQ(matcher_.evaluate(map_, scan_.match_points, truth_, 0.0).old_share, 0.0);
  EXPECT_GT(matcher_.evaluate(map_, scan_.match_points, truth_, 1.0).old_share, 0.85);
}

TEST(ScanMatcherInACorridor, LeavesItsDirectionToThePrior) {
  RandomStream noise(3, 0);
  testing::Walls walls;
  testing::add_box(walls, -50.0, -1.0, 50.0, 1.01);
  auto laser = testing::full_circle_laser(360);
  laser.range_max = 6.0;
  const GridMap map = map_of(walls, laser, noise);
  const common::Pose2 truth{0.2, 0.1, 0.0};
  const ScanBeams scan = beams_at(walls, laser, truth, noise);
  const ScanMatcher matcher(ScanMatcherOptions{}, kGain);

  const common::Pose2 start{0.2, 0.05, 0.02};
  const ScanMatch match =
      matcher.match(map, scan.match_points, start, {start, Eigen::Vector3d(400.0, 400.0, 400.0).asDiagonal()});
  EXPECT_NEAR(match.pose.y, truth.y, 0.005);
  EXPECT_NEAR(match.pose.x, start.x, 0.03);
  const auto direction = degenerate_direction(match.fit.information, 0.03);
  ASSERT_TRUE(direction);
  EXPECT_NEAR(*direction, 0.0, 0.1);
}

TEST(DegenerateDirection, IsTheWeakAxisAndNothingWhenAllAreHeld) {
  EXPECT_FALSE(degenerate_direction(Eigen::Vector3d(100.0, 50.0, 10.0).asDiagonal().toDenseMatrix(), 0.03));
  const auto along_y = degenerate_direction(Eigen::Vector3d(100.0, 0.5, 10.0).asDiagonal().toDenseMatrix(), 0.03);
  ASSERT_TRUE(along_y);
  EXPECT_NEAR(std::abs(*along_y), std::numbers::pi / 2.0, 1e-6);
}

TEST(DegenerateDirection, TakesOutWhatTheHeadingExplains) {
  // y is held only together with the heading: one distant point seen across.
  Eigen::Matrix3d information = Eigen::Vector3d(100.0, 0.0, 0.0).asDiagonal();
  const Eigen::Vector3d coupled(0.0, 1.0, 5.0);
  information += 100.0 * coupled * coupled.transpose();
  EXPECT_TRUE(degenerate_direction(information, 0.03));
}

TEST(DegenerateDirection, FlagsAScanThatHoldsNothing) {
  EXPECT_TRUE(degenerate_direction(Eigen::Matrix3d::Zero(), 0.03));
}

}  // namespace
}  // namespace slamfuse::laser_slam
