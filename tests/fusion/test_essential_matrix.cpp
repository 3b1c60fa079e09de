// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/essential_matrix.hpp"

#include <gtest/gtest.h>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "fusion/seed004.hpp"
#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

constexpr double kSize = 1000.0;

ImagePairs noisy_images(double noise) {
  TestNoise random(5);
  ImagePairs images;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d point(kSize * random.uniform(), kSize * random.uniform());
    images.laser.push_back(point);
    images.visual.emplace_back(point.x() + noise * random.normal(), point.y() + noise * random.normal());
  }
  return images;
}

TEST(EssentialMotion, GivesAnEssentialMatrixARotationAndTheEpipolarConstraint) {
  const ImagePairs images = noisy_images(5.0);

  const auto motion = estimate_essential_motion(images, kSize);

  ASSERT_TRUE(motion.has_value());
  const Eigen::Vector3d singular = Eigen::JacobiSVD<Eigen::Matrix3d>(motion->E).singularValues();
  EXPECT_NEAR(singular[0], 1.0, 1e-9);
  EXPECT_NEAR(singular[1], 1.0, 1e-9);
  EXPECT_NEAR(singular[2], 0.0, 1e-9);
  double sum = 0.0;
  for (std::size_t i = 0; i < images.laser.size(); ++i) {
    const Eigen::Vector3d l((images.laser[i] / kSize).x() - 0.5, (images.laser[i] / kSize).y() - 0.5, 1.0);
    const Eigen::Vector3d v((images.visual[i] / kSize).x() - 0.5, (images.visual[i] / kSize).y() - 0.5, 1.0);
    sum += std::abs(l.dot(motion->E * v));
  }
  EXPECT_LT(sum / static_cast<double>(images.laser.size()), 0.01);
}

TEST(EssentialMotion, NeedsEightPairs) {
  ImagePairs images = noisy_images(1.0);
  images.laser.resize(7);
  images.visual.resize(7);

  EXPECT_FALSE(estimate_essential_motion(images, kSize).has_value());
}

/// Misprint 4: images in the plane z = 1 do not determine the essential matrix, and its translation has no length.
TEST(EssentialMotionMisprint4, IsTheIdentityWhereItDoesNotLowerTheHeldOutResidualAndTheReportSaysSo) {
  const auto laser = flat_path(300);
  const auto visual = visual_path(laser, stretched_map(20.0, 2.0, 2.2, 1.0, 1.0), 0.01, 0.0, 11);

  const auto fit = fit_seed004(pair_trajectories(laser, visual, {}), {}, 10, 0.35);

  ASSERT_TRUE(fit.has_value());
  if (fit->essential_applied) {
    EXPECT_NE(fit->mapping.T_ess, Eigen::Matrix4d::Identity());
    EXPECT_NE(fit->essential_report.find("applied"), std::string::npos);
  } else {
    EXPECT_EQ(fit->mapping.T_ess, Eigen::Matrix4d::Identity());
    EXPECT_NE(fit->essential_report.find("identity"), std::string::npos);
  }
  EXPECT_NE(fit->essential_report.find("px"), std::string::npos);
}

TEST(EssentialMotionMisprint4, IsNeverAppliedToImagesThatAlreadyCoincide) {
  const auto laser = flat_path(300);
  const auto visual = visual_path(laser, stretched_map(0.0, 1.0, 1.0, 0.0, 0.0), 0.0, 0.0, 11);

  const auto fit = fit_seed004(pair_trajectories(laser, visual, {}), {}, 10, 0.35);

  ASSERT_TRUE(fit.has_value());
  EXPECT_FALSE(fit->essential_applied);
  EXPECT_EQ(fit->mapping.T_ess, Eigen::Matrix4d::Identity());
}

TEST(EssentialMotionMisprint4, CanBeSwitchedOff) {
  const auto laser = flat_path(300);
  const auto visual = visual_path(laser, stretched_map(20.0, 2.0, 2.2, 1.0, 1.0), 0.01, 0.0, 11);
  Seed004Options options;
  options.use_essential_matrix = false;

  const auto fit = fit_seed004(pair_trajectories(laser, visual, {}), options, 10, 0.35);

  ASSERT_TRUE(fit.has_value());
  EXPECT_EQ(fit->essential_report, "identity: switched off");
}

}  // namespace
}  // namespace slamfuse::fusion
