// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/mapping_matrix.hpp"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "fusion/seed004.hpp"
#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

TEST(MappingMatrix, PlanarPartDoesWhatTheProductDoesToThePlane) {
  const auto laser = flat_path(200);
  const auto visual = visual_path(laser, stretched_map(33.0, 0.5, 0.6, -1.0, 2.0), 0.01, 0.0, 2);

  const auto fit = fit_seed004(pair_trajectories(laser, visual, {}), {}, 10, 0.35);

  ASSERT_TRUE(fit.has_value());
  const Eigen::Vector4d product = fit->mapping.product() * Eigen::Vector4d(1.3, -0.7, 0.0, 1.0);
  const Eigen::Vector2d planar = fit->mapping.planar() * Eigen::Vector2d(1.3, -0.7);
  EXPECT_NEAR(product.x(), planar.x(), 1e-9);
  EXPECT_NEAR(product.y(), planar.y(), 1e-9);
}

/// Misprint 2: with T_traj in the place of T_curv, as eq. 7 prints it, the map misses the laser's path.
TEST(MappingMatrixMisprint2, HasTCurvBesideTheEssentialMatrixAndTTrajAtTheEnds) {
  const auto laser = flat_path(300);
  const auto visual = visual_path(laser, stretched_map(33.0, 0.5, 0.6, -1.0, 2.0), 0.0, 0.0, 2);
  const auto fit = fit_seed004(pair_trajectories(laser, visual, {}), {}, 10, 0.35);
  ASSERT_TRUE(fit.has_value());
  MappingMatrix printed = fit->mapping;
  printed.T_curv_laser = printed.T_traj_laser;
  printed.T_curv_visual = printed.T_traj_visual;

  const auto worst = [&](const PlanarAffine& map) {
    double error = 0.0;
    for (std::size_t i = 0; i < laser.size(); ++i) {
      error = std::max(error, (laser[i].pose.translation() - map * visual[i].pose.translation()).norm());
    }
    return error;
  };

  EXPECT_LT(worst(fit->mapping.planar()), 0.2);  // half a degree of the search's grid over 6 m
  EXPECT_GT(worst(printed.planar()), 0.5);
}

TEST(MappingMatrix, OfADirectEstimatorIsTheMapItself) {
  const PlanarAffine map = stretched_map(70.0, 2.0, 3.0, 1.0, -1.0);

  const MappingMatrix mapping = to_mapping_matrix(map);

  EXPECT_TRUE(mapping.planar().matrix().isApprox(map.matrix(), 1e-14));
  EXPECT_NEAR(mapping.product()(2, 2), std::sqrt(6.0), 1e-12);
}

}  // namespace
}  // namespace slamfuse::fusion
