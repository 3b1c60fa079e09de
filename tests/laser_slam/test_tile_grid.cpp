// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/tile_grid.hpp"

#include <gtest/gtest.h>

#include "laser_slam/parallel_for.hpp"

namespace slamfuse::laser_slam {
namespace {

TEST(TileGrid, HasNoTilesUntilWrittenTo) {
  TileGrid grid;
  EXPECT_EQ(grid.find(0, 0), nullptr);
  ASSERT_TRUE(grid.include(-2, -2, 3, 3));
  EXPECT_EQ(grid.find(-2, 3), nullptr);
  EXPECT_EQ(grid.count(), 0u);
  grid.write(-2, 3).log_odds[5] = 9;
  ASSERT_NE(grid.find(-2, 3), nullptr);
  EXPECT_EQ(grid.find(-2, 3)->log_odds[5], 9);
  EXPECT_EQ(grid.count(), 1u);
}

TEST(TileGrid, SharesTilesWithItsCopiesUntilOneWrites) {
  TileGrid original;
  ASSERT_TRUE(original.include(0, 0, 1, 0));
  original.write(0, 0).log_odds[0] = 1;
  original.write(1, 0).log_odds[0] = 2;

  TileGrid copy = original;
  EXPECT_EQ(copy.count_shared(original), 2u);
  copy.write(0, 0).log_odds[0] = 7;

  EXPECT_EQ(copy.count_shared(original), 1u);
  EXPECT_EQ(original.find(0, 0)->log_odds[0], 1);
  EXPECT_EQ(copy.find(0, 0)->log_odds[0], 7);
  EXPECT_EQ(copy.find(1, 0), original.find(1, 0));
}

TEST(TileGrid, WritesInPlaceOnceItIsTheOnlyOwner) {
  TileGrid grid;
  ASSERT_TRUE(grid.include(0, 0, 0, 0));
  grid.write(0, 0);
  { const TileGrid passing_copy = grid; }
  const Tile* before = grid.find(0, 0);
  grid.write(0, 0).log_odds[0] = 3;
  EXPECT_EQ(grid.find(0, 0), before);
}

TEST(TileGrid, KeepsItsTilesWhenItGrowsInAnyDirection) {
  TileGrid grid;
  ASSERT_TRUE(grid.include(0, 0, 0, 0));
  grid.write(0, 0).log_odds[1] = 4;
  const TileGrid copy = grid;
  ASSERT_TRUE(grid.include(-40, -3, 50, 70));
  EXPECT_EQ(grid.find(0, 0)->log_odds[1], 4);
  EXPECT_EQ(grid.count_shared(copy), 1u);
  EXPECT_LE(grid.min_x(), -40);
  EXPECT_GT(grid.min_y() + grid.height(), 70);
}

TEST(TileGrid, MayBeWrittenToByManyThreadsThroughTheirOwnCopies) {
  TileGrid original;
  ASSERT_TRUE(original.include(0, 0, 0, 0));
  original.write(0, 0).log_odds[0] = 1;
  std::vector<TileGrid> copies(16, original);
  parallel_for(16, 4, [&](int i, int) {
    copies[static_cast<std::size_t>(i)].write(0, 0).log_odds[0] = static_cast<std::int8_t>(i);
  });
  for (int i = 0; i < 16; ++i) EXPECT_EQ(copies[static_cast<std::size_t>(i)].find(0, 0)->log_odds[0], i);
  EXPECT_EQ(original.find(0, 0)->log_odds[0], 1);
}

}  // namespace
}  // namespace slamfuse::laser_slam
