// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/fused_map.hpp"

#include <gtest/gtest.h>

#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

common::Landmark landmark(double x, double y, double z) {
  common::Landmark result;
  result.position = {x, y, z};
  result.covariance = Eigen::Vector3d(1e-2, 4e-2, 9e-2).asDiagonal();
  return result;
}

/// A wall along x = 1 m in a grid of 5 cm cells.
common::OccupancyGrid wall() {
  common::OccupancyGrid grid;
  grid.resolution = 0.05;
  grid.width = 60;
  grid.height = 60;
  grid.cells.assign(3600, 0);
  for (std::size_t row = 0; row < 60; ++row) grid.cells[row * 60 + 20] = 100;  // centre at 1.025 m
  grid.cells[59 * 60] = common::OccupancyGrid::kUnknown;
  return grid;
}

TEST(ToLaserFrame, MovesPositionHeightAndCovariance) {
  Alignment alignment;
  alignment.map = stretched_map(90.0, 2.0, 2.0, 1.0, -1.0);
  alignment.mean_scale = 2.0;

  const auto moved = to_laser_frame({landmark(0.5, 0.25, 0.6)}, alignment);

  ASSERT_EQ(moved.size(), 1u);
  EXPECT_TRUE(moved[0].position.isApprox(Eigen::Vector3d(0.5, 0.0, 1.2), 1e-12));
  EXPECT_NEAR(moved[0].covariance(0, 0), 4.0 * 4e-2, 1e-12);
  EXPECT_NEAR(moved[0].covariance(1, 1), 4.0 * 1e-2, 1e-12);
  EXPECT_NEAR(moved[0].covariance(2, 2), 4.0 * 9e-2, 1e-12);
}

TEST(ToLaserFrame, TheAlignmentsOwnUncertaintyGrowsWithTheDistanceFromTheOrigin) {
  Alignment alignment;
  alignment.covariance = 1e-4 * Eigen::Matrix<double, 6, 6>::Identity();

  const auto moved = to_laser_frame({landmark(0.0, 0.0, 0.0), landmark(10.0, 0.0, 0.0)}, alignment);

  EXPECT_NEAR(moved[0].covariance(0, 0), 1e-2 + 1e-4, 1e-12);
  EXPECT_NEAR(moved[1].covariance(0, 0), 1e-2 + 1e-4 + 1e-2, 1e-12);
}

TEST(MeasureAgreement, GivesTheDistancesToTheNearestOccupiedCell) {
  std::vector<common::Landmark> landmarks;
  for (int i = 0; i <= 10; ++i) landmarks.push_back(landmark(1.025 + 0.01 * i, 1.025, 1.0));

  const MapAgreement agreement = measure_agreement(landmarks, wall(), {});

  EXPECT_EQ(agreement.landmarks, 11u);
  EXPECT_NEAR(agreement.median_distance, 0.05, 1e-9);
  EXPECT_NEAR(agreement.distance_90, 0.09, 1e-9);
}

TEST(MeasureAgreement, LeavesOutFloorAndCeiling) {
  const MapAgreement agreement =
      measure_agreement({landmark(1.0, 1.0, 0.0), landmark(1.0, 1.0, 2.4), landmark(1.025, 1.025, 1.0)}, wall(), {});

  EXPECT_EQ(agreement.landmarks, 1u);
  EXPECT_NEAR(agreement.median_distance, 0.0, 1e-9);
}

TEST(MeasureAgreement, HasNothingToSayWithoutLandmarksOrWalls) {
  common::OccupancyGrid empty = wall();
  empty.cells.assign(3600, 0);

  EXPECT_EQ(measure_agreement({}, wall(), {}).landmarks, 0u);
  EXPECT_EQ(measure_agreement({landmark(1.0, 1.0, 1.0)}, empty, {}).landmarks, 0u);
}

}  // namespace
}  // namespace slamfuse::fusion
