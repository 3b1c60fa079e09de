// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/keyframe.hpp"

#include <gtest/gtest.h>

#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

TEST(StoredScan, ComesBackButForRounding) {
  common::LaserScan scan = testing::scan_at(testing::room(), testing::full_circle_laser(), 0, {0.5, 0.3, 0.2});
  scan.ranges[7] = HUGE_VALF;  // sees nothing: clears the map, is not matched
  const ScanBeams beams = *project_scan(scan, testing::full_circle_laser(), {80.0, 4.0, 50}, {0.3, 0.0, 0.5});
  const ScanBeams back = StoredScan(beams).restore();
  ASSERT_EQ(back.beams.size(), beams.beams.size());
  for (std::size_t i = 0; i < beams.beams.size(); ++i) {
    EXPECT_EQ(back.beams[i].hit, beams.beams[i].hit);
    EXPECT_LT((back.beams[i].end - beams.beams[i].end).norm(), 1e-5);
    EXPECT_LT((back.beams[i].origin - beams.beams[i].origin).norm(), 1e-5);
  }
  ASSERT_EQ(back.match_points.size(), beams.match_points.size());
  for (std::size_t i = 0; i < beams.match_points.size(); ++i) {
    EXPECT_LT((back.match_points[i] - beams.match_points[i]).norm(), 1e-5);
  }
}

TEST(StoredScan, IsEmptyUntilItHoldsOne) {
  EXPECT_TRUE(StoredScan().empty());
  EXPECT_TRUE(StoredScan().restore().beams.empty());
}

}  // namespace
}  // namespace slamfuse::laser_slam
