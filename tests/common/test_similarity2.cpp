// SPDX-License-Identifier: BSD-3-Clause
#include "common/similarity2.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "common/angle.hpp"

namespace slamfuse::common {
namespace {

using Points = std::vector<Eigen::Vector2d>;

const Similarity2 kTruth{0.243, {3.0, -7.0, 2.8}};

Points spiral(int count) {
  Points points;
  for (int i = 0; i < count; ++i) points.emplace_back(0.05 * i * std::cos(0.1 * i), 0.04 * i * std::sin(0.1 * i));
  return points;
}

Points moved(const Points& points, const Similarity2& transform) {
  Points result;
  for (const Eigen::Vector2d& point : points) result.push_back(transform * point);
  return result;
}

TEST(Similarity2, ScalesTurnsAndShiftsPointsAndPoses) {
  const Similarity2 transform{2.0, {1.0, 0.0, std::numbers::pi / 2}};

  const Eigen::Vector2d point = transform * Eigen::Vector2d(3.0, 0.0);
  const Pose2 pose = transform * Pose2{3.0, 0.0, 0.5};

  EXPECT_NEAR((point - Eigen::Vector2d(1.0, 6.0)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((pose.translation() - point).norm(), 0.0, 1e-15);
  EXPECT_NEAR(pose.theta, std::numbers::pi / 2 + 0.5, 1e-15);
}

TEST(FitSimilarity, RecoversAnExactTransform) {
  const Points source = spiral(100);

  const auto fit = fit_similarity(source, moved(source, kTruth), FitGroup::kSimilarity);

  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->scale, kTruth.scale, 1e-14);
  EXPECT_NEAR(fit->pose.theta, kTruth.pose.theta, 1e-13);
  EXPECT_NEAR((fit->pose.translation() - kTruth.pose.translation()).norm(), 0.0, 1e-12);
}

TEST(FitSimilarity, RecoversATransformUnderNoise) {
  const Points source = spiral(500);
  Points target = moved(source, kTruth);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.05);
  for (Eigen::Vector2d& point : target) point += Eigen::Vector2d(noise(random), noise(random));

  const auto fit = fit_similarity(source, target, FitGroup::kSimilarity);

  // Standard deviations are noise / (sqrt(n) * spread), about 2e-4 here.
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->scale, kTruth.scale, 1e-3);
  EXPECT_NEAR(angle_difference(fit->pose.theta, kTruth.pose.theta), 0.0, 4e-3);
  EXPECT_NEAR((fit->pose.translation() - kTruth.pose.translation()).norm(), 0.0, 0.01);
}

TEST(FitSimilarity, KeepsTheScaleOfARigidFit) {
  const Points source = spiral(100);

  const auto fit = fit_similarity(source, moved(source, {2.0, {1, 2, -3}}), FitGroup::kRigid);

  ASSERT_TRUE(fit.has_value());
  EXPECT_EQ(fit->scale, 1.0);
  EXPECT_NEAR(fit->pose.theta, -3.0, 1e-13);
}

TEST(FitSimilarity, LetsNoPointOfWeightZeroHaveASay) {
  Points source = spiral(50);
  Points target = moved(source, kTruth);
  std::vector<double> weights(source.size(), 2.5);
  target[7] = {1000, 1000};
  weights[7] = 0.0;

  const auto fit = fit_similarity(source, target, FitGroup::kSimilarity, weights);

  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->scale, kTruth.scale, 1e-13);
}

TEST(FitSimilarity, WeighsAPointLikeThatManyPoints) {
  const Points source = {{0, 0}, {1, 0}, {0, 1}, {0, 1}, {0, 1}};
  const Points target = {{0, 0}, {1, 0.2}, {0.1, 1.3}, {0.1, 1.3}, {0.1, 1.3}};
  const std::vector<double> weights = {1, 1, 3};

  const auto repeated = fit_similarity(source, target, FitGroup::kSimilarity);
  const auto weighted =
      fit_similarity(std::span(source).first(3), std::span(target).first(3), FitGroup::kSimilarity, weights);

  ASSERT_TRUE(repeated.has_value() && weighted.has_value());
  EXPECT_NEAR((repeated->matrix() - weighted->matrix()).norm(), 0.0, 1e-14);
}

TEST(FitSimilarity, NeedsNoMoreThanTwoPoints) {
  const auto fit = fit_similarity(Points{{0, 0}, {2, 0}}, Points{{1, 1}, {1, 5}}, FitGroup::kSimilarity);

  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->scale, 2.0, 1e-15);
  EXPECT_NEAR(fit->pose.theta, std::numbers::pi / 2, 1e-15);
}

TEST(FitSimilarity, RefusesDegeneratePoints) {
  const Points three = {{0.1, 0.2}, {1.3, 0.2}, {0.1, 1.7}};
  const Points same(3, Eigen::Vector2d(0.1, 0.2));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const FitGroup group : {FitGroup::kRigid, FitGroup::kSimilarity}) {
    EXPECT_FALSE(fit_similarity({}, {}, group).has_value());
    EXPECT_FALSE(fit_similarity(Points{{1, 1}}, Points{{2, 2}}, group).has_value());
    EXPECT_FALSE(fit_similarity(three, Points{{1, 1}, {2, 2}}, group).has_value());
    EXPECT_FALSE(fit_similarity(same, three, group).has_value());
    EXPECT_FALSE(fit_similarity(three, same, group).has_value());
    EXPECT_FALSE(fit_similarity(same, same, group).has_value());
    EXPECT_FALSE(fit_similarity(three, three, group, std::vector<double>{1, 1}).has_value());
    EXPECT_FALSE(fit_similarity(three, three, group, std::vector<double>{0, 0, 0}).has_value());
    EXPECT_FALSE(fit_similarity(three, three, group, std::vector<double>{0, 1, 0}).has_value());
    EXPECT_FALSE(fit_similarity(three, Points{{0, 0}, {1, nan}, {0, 1}}, group).has_value());
  }
}

TEST(FitSimilarity, RefusesAMirroredCircleForWhichEveryAngleIsAsGood) {
  const Points circle = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  const Points mirrored = {{1, 0}, {0, -1}, {-1, 0}, {0, 1}};

  EXPECT_FALSE(fit_similarity(circle, mirrored, FitGroup::kRigid).has_value());
}

}  // namespace
}  // namespace slamfuse::common
