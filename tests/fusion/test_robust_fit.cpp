// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/robust_fit.hpp"

#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

constexpr double kSeparation = 0.35;

std::vector<PosePair> noisy_pairs(const PlanarAffine& map, double noise, double outliers, std::uint64_t seed) {
  const auto laser = flat_path(300);
  return pair_trajectories(laser, visual_path(laser, map, noise, outliers, seed), {});
}

TEST(FitRobust, ToleratesFortyPercentOutliers) {
  const PlanarAffine truth = stretched_map(100.0, 2.0, 2.0, 5.0, 6.0);

  const auto fit = fit_robust(noisy_pairs(truth, 0.01, 0.4, 8), RobustModel::kSimilarity, {}, kSeparation);

  ASSERT_TRUE(fit.has_value());
  EXPECT_LT((fit->map.linear - truth.linear).norm(), 0.01);
  EXPECT_NEAR(fit->sigma, 0.02, 0.008);
}

TEST(FitRobust, MeasuresTheNoiseAndFindsTheExactMapWithoutIt) {
  const PlanarAffine truth = stretched_map(-20.0, 0.3, 0.4, 1.0, 2.0);

  const auto exact = fit_robust(noisy_pairs(truth, 0.0, 0.0, 8), RobustModel::kAffine, {}, kSeparation);

  ASSERT_TRUE(exact.has_value());
  EXPECT_LT((exact->map.matrix() - truth.matrix()).norm(), 1e-9);
}

TEST(FitRobust, ARigidFitKeepsTheScaleAndFindsTheRest) {
  const PlanarAffine truth = stretched_map(70.0, 1.0, 1.0, 3.0, -2.0);

  const auto fit = fit_robust(noisy_pairs(truth, 0.02, 0.3, 8), RobustModel::kRigid, {}, kSeparation);

  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->map.linear.determinant(), 1.0, 1e-12);
  EXPECT_LT((fit->map.linear - truth.linear).norm(), 0.005);
  EXPECT_LT((fit->map.translation - truth.translation).norm(), 0.02);
}

TEST(FitRobust, NoRotationFitsScaledPathsBetterThanTheRigidOneFound) {
  const auto pairs = noisy_pairs(stretched_map(70.0, 1.03, 1.03, 3.0, -2.0), 0.0, 0.0, 8);
  const auto loss = [&](const PlanarAffine& map) {
    double sum = 0.0;
    for (const PosePair& pair : pairs)
      sum += (pair.laser.translation() - map * pair.visual.translation()).squaredNorm();
    return sum;
  };
  RobustFitOptions options;
  options.inlier_sigmas = 10.0;

  const auto fit = fit_robust(pairs, RobustModel::kRigid, options, kSeparation);

  ASSERT_TRUE(fit.has_value());
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const PosePair& pair : pairs) centre += pair.visual.translation() / static_cast<double>(pairs.size());
  EXPECT_NEAR(take_apart(fit->map).rotation, 70.0 * std::numbers::pi / 180.0, 0.003);
  for (const double turn : {-0.01, 0.01}) {
    PlanarAffine other = fit->map;
    other.linear = Eigen::Rotation2Dd(turn) * other.linear;
    other.translation = fit->map * centre - other.linear * centre;
    EXPECT_GT(loss(other), loss(fit->map));
  }
}

/// The true map must lie inside the 95 % ellipsoid in about 95 % of the runs.
TEST(FitRobust, CovarianceIsCalibratedOverNoiseAndOutliers) {
  const PlanarAffine truth = stretched_map(30.0, 2.0, 2.0, 1.0, -1.0);
  constexpr int kRuns = 400;
  constexpr double kChiSquare95Of6 = 12.592;
  int inside = 0;
  for (int run = 0; run < kRuns; ++run) {
    const auto fit =
        fit_robust(noisy_pairs(truth, 0.02, 0.1 * (run % 3), 100 + run), RobustModel::kAffine, {}, kSeparation);
    ASSERT_TRUE(fit.has_value());
    Eigen::Matrix<double, 6, 1> error;
    const Eigen::Matrix2d d = fit->map.linear - truth.linear;
    error << d(0, 0), d(0, 1), d(1, 0), d(1, 1), fit->map.translation - truth.translation;
    if (error.dot(fit->covariance.ldlt().solve(error)) < kChiSquare95Of6) ++inside;
  }

  EXPECT_GE(inside, static_cast<int>(0.91 * kRuns));
  EXPECT_LE(inside, static_cast<int>(0.99 * kRuns));
}

TEST(FitRobust, ErrorsThatDriftWidenTheCovariance) {
  const PlanarAffine truth = stretched_map(30.0, 2.0, 2.0, 1.0, -1.0);
  const auto laser = flat_path(300);
  auto white = visual_path(laser, truth, 0.02, 0.0, 3);
  auto drifting = visual_path(laser, truth, 0.0, 0.0, 3);
  TestNoise random(5);
  Eigen::Vector2d drift = Eigen::Vector2d::Zero();
  for (auto& pose : drifting) {
    drift = 0.97 * drift + 0.02 * std::sqrt(1.0 - 0.97 * 0.97) * Eigen::Vector2d(random.normal(), random.normal());
    pose.pose.x += drift.x();
    pose.pose.y += drift.y();
  }

  const auto of_white = fit_robust(pair_trajectories(laser, white, {}), RobustModel::kSimilarity, {}, kSeparation);
  const auto of_drift = fit_robust(pair_trajectories(laser, drifting, {}), RobustModel::kSimilarity, {}, kSeparation);

  ASSERT_TRUE(of_white && of_drift);
  EXPECT_GT(of_drift->covariance(4, 4), 5.0 * of_white->covariance(4, 4));
}

TEST(FitRobust, RefusesTooFewPairsAndPointsThatCoincide) {
  std::vector<PosePair> pairs(30);
  EXPECT_FALSE(fit_robust(pairs, RobustModel::kSimilarity, {}, kSeparation).has_value());
  EXPECT_FALSE(fit_robust({}, RobustModel::kAffine, {}, kSeparation).has_value());
}

TEST(FitRobust, DependsOnTheSeedAloneForItsSamples) {
  const auto pairs = noisy_pairs(stretched_map(30.0, 2.0, 2.1, 1.0, -1.0), 0.02, 0.3, 1);

  const auto a = fit_robust(pairs, RobustModel::kAffine, {}, kSeparation);
  const auto b = fit_robust(pairs, RobustModel::kAffine, {}, kSeparation);

  EXPECT_EQ(a->map.linear, b->map.linear);
  EXPECT_EQ(a->runner_up_loss, b->runner_up_loss);
}

}  // namespace
}  // namespace slamfuse::fusion
