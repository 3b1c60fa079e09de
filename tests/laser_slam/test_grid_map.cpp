// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/grid_map.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

ScanBeams single_beam(const Eigen::Vector2d& end, bool hit = true) {
  ScanBeams scan;
  scan.beams.push_back({Eigen::Vector2d::Zero(), end, hit});
  if (hit) scan.match_points.push_back(end);
  return scan;
}

class GridMapTest : public ::testing::Test {
 protected:
  void insert(const ScanBeams& scan, const common::Pose2& pose = {}, double path = 0.0) {
    map_.insert(scan, pose, path, scratch_);
  }
  GridMap map_{MapOptions{}};
  InsertionScratch scratch_;
};

TEST_F(GridMapTest, KnowsOnlyWhatABeamHasSeen) {
  EXPECT_FALSE(map_.known_at({0.5, 0.0}));
  insert(single_beam({1.01, 0.0}));
  EXPECT_TRUE(map_.known_at({0.5, 0.0}));
  EXPECT_TRUE(map_.known_at({1.01, 0.0}));
  EXPECT_FALSE(map_.known_at({1.2, 0.0}));
  EXPECT_FALSE(map_.known_at({0.5, 0.3}));
}

TEST_F(GridMapTest, RemembersTheMeanEndpointFinerThanItsCells) {
  insert(single_beam({1.013, 0.021}));
  insert(single_beam({1.019, 0.027}));
  const Surface surface = map_.surface_at({1.0, 0.0}, 1);
  EXPECT_GT(surface.weight, 0.0);
  EXPECT_NEAR(surface.mean.x(), 1.016, 1e-4);
  EXPECT_NEAR(surface.mean.y(), 0.024, 1e-4);
}

TEST_F(GridMapTest, FindsSurfacesAcrossTileBordersAndForNegativeCoordinates) {
  for (const Eigen::Vector2d& end : {Eigen::Vector2d(1.601, 0.01), Eigen::Vector2d(-0.002, -1.603)}) {
    insert(single_beam(end));
    for (double dx : {-0.04, 0.0, 0.04}) {
      for (double dy : {-0.04, 0.0, 0.04}) {
        const Surface surface = map_.surface_at(end + Eigen::Vector2d(dx, dy), 2);
        ASSERT_GT(surface.weight, 0.0);
        EXPECT_LT((surface.mean - end).norm(), 1e-3);
      }
    }
  }
}

TEST_F(GridMapTest, SeesNoSurfaceBeyondItsReach) {
  insert(single_beam({1.0, 0.0}));
  EXPECT_EQ(map_.surface_at({1.2, 0.0}, 2).weight, 0.0);
  EXPECT_FALSE(map_.occupied_near({1.2, 0.0}));
  EXPECT_TRUE(map_.occupied_near({1.04, 0.04}));
}

TEST_F(GridMapTest, ClearsWhatWasThereAndIsGone) {
  insert(single_beam({1.01, 0.0}));
  for (int i = 0; i < 10; ++i) insert(single_beam({3.0, 0.0}));
  EXPECT_EQ(map_.surface_at({1.01, 0.0}, 1).weight, 0.0);
  EXPECT_GT(map_.surface_at({3.0, 0.0}, 1).weight, 0.0);
}

TEST_F(GridMapTest, DoesNotClearACellInWhichABeamOfTheSameScanEnds) {
  ScanBeams grazing = single_beam({1.01, 0.0});
  for (int i = 0; i < 20; ++i)
    grazing.beams.push_back({Eigen::Vector2d::Zero(), Eigen::Vector2d(2.0, 0.001 * i), true});
  insert(grazing);
  EXPECT_GT(map_.surface_at({1.01, 0.0}, 1).weight, 0.0);
}

TEST_F(GridMapTest, MarksBeamsWithoutReturnAsFreeOnly) {
  insert(single_beam({2.0, 0.0}, false));
  EXPECT_TRUE(map_.known_at({1.0, 0.0}));
  EXPECT_EQ(map_.surface_at({2.0, 0.0}, 2).weight, 0.0);
}

TEST_F(GridMapTest, TellsWhenASurfaceWasLastSeen) {
  insert(single_beam({1.0, 0.0}), {}, 3.0);
  EXPECT_NEAR(map_.surface_at({1.0, 0.0}, 1).last_path, 3.0, Endpoints::kPathUnit);
  insert(single_beam({1.0, 0.0}), {}, 7.0);
  EXPECT_NEAR(map_.surface_at({1.0, 0.0}, 1).last_path, 7.0, Endpoints::kPathUnit);
  insert(single_beam({1.0, 0.0}), {}, 47.0);
  EXPECT_NEAR(map_.surface_at({1.0, 0.0}, 1).last_path, 27.0, Endpoints::kPathUnit) << "halfway after a long absence";
}

TEST_F(GridMapTest, MeasuresAWallsMomentsAlongIt) {
  ScanBeams wall;
  for (int i = -20; i <= 20; ++i)
    wall.beams.push_back({Eigen::Vector2d::Zero(), Eigen::Vector2d(2.013, 0.01 * i), true});
  insert(wall);
  const Surface surface = map_.surface_at({2.013, 0.0}, 2);
  EXPECT_NEAR(surface.mean.x(), 2.013, 1e-3);
  EXPECT_LT(surface.xx, 1e-5);
  EXPECT_GT(surface.yy, 5e-4);
}

TEST_F(GridMapTest, IgnoresBeamsThatEndImpossiblyFarOut) {
  insert(single_beam({1.0, 0.0}), {1e9, 0.0, 0.0});
  EXPECT_TRUE(map_.empty());
}

TEST_F(GridMapTest, CanBeAskedAboutAnyPlace) {
  insert(single_beam({1.0, 0.0}));
  for (const double far : {1e6, 1e9, 1e30, -1e9, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(map_.surface_at({far, -far}, 4).weight, 0.0) << far;
    EXPECT_FALSE(map_.known_at({-far, far})) << far;
    EXPECT_FALSE(map_.occupied_near({far, far})) << far;
  }
}

TEST_F(GridMapTest, LeavesOutScansThatWouldStretchItBeyondItsLimit) {
  insert(single_beam({1.0, 0.0}));
  insert(single_beam({1.0, 0.0}), {15000.0, 15000.0, 0.0});
  EXPECT_FALSE(map_.known_at({15000.5, 15000.0}));
  EXPECT_LE(static_cast<std::size_t>(map_.tiles().width()) * static_cast<std::size_t>(map_.tiles().height()),
            TileGrid::kMaxTiles);
  insert(single_beam({1.0, 0.0}), {200.0, 200.0, 0.0});
  EXPECT_TRUE(map_.known_at({200.5, 200.0})) << "and goes on where it can";
}

TEST(GridMap, TakesTheWeakestEvidenceItsOptionsAllow) {
  MapOptions options;
  options.hit_probability = 0.51;
  options.miss_probability = 0.49;
  GridMap map(options);
  InsertionScratch scratch;
  map.insert(single_beam({1.0, 0.0}), {}, 0.0, scratch);
  EXPECT_TRUE(map.known_at({1.0, 0.0}));
  EXPECT_TRUE(map.known_at({0.5, 0.0}));
}

TEST_F(GridMapTest, LeavesACopyAloneWhenItChanges) {
  insert(single_beam({1.0, 0.0}));
  const GridMap copy = map_;
  for (int i = 0; i < 10; ++i) insert(single_beam({3.0, 0.0}));
  EXPECT_GT(copy.surface_at({1.0, 0.0}, 1).weight, 0.0);
  EXPECT_EQ(copy.surface_at({3.0, 0.0}, 1).weight, 0.0);
}

}  // namespace
}  // namespace slamfuse::laser_slam
