// SPDX-License-Identifier: BSD-3-Clause
#include "service/grid_file.hpp"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using testing::HasSubstr;

/// Two rows of three: the lower one free, unknown, occupied; the upper one all unknown but a free corner.
common::OccupancyGrid small_grid() {
  common::OccupancyGrid grid;
  grid.resolution = 0.05;
  grid.width = 3;
  grid.height = 2;
  grid.origin = {-1.5, 2.25};
  grid.cells = {0, -1, 100, 10, -1, 50};
  return grid;
}

TEST(GridFile, StartsTheImageWithTheTopRow) {
  const std::string pgm = grid_to_pgm(small_grid());
  const std::string header = "P5\n3 2\n255\n";
  ASSERT_EQ(pgm.size(), header.size() + 6);
  EXPECT_EQ(pgm.substr(0, header.size()), header);
  EXPECT_EQ(pgm.substr(header.size()), std::string("\xfe\xcd\xcd\xfe\xcd\x00", 6));
}

TEST(GridFile, WritesWhatNav2sMapServerNeeds) {
  const std::string yaml = grid_to_yaml(small_grid(), "grid.pgm");
  for (const char* line : {"image: grid.pgm\n", "mode: trinary\n", "resolution: 0.05\n", "origin: [-1.5, 2.25, 0]\n",
                           "negate: 0\n", "occupied_thresh: 0.65\n", "free_thresh: 0.196\n"}) {
    EXPECT_THAT(yaml, HasSubstr(line));
  }
}

TEST(GridFile, ReadsBackFreeOccupiedAndUnknown) {
  const auto grid = small_grid();
  const auto read = grid_from_files(grid_to_pgm(grid), grid_to_yaml(grid, "grid.pgm"));
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(read->cells, (std::vector<std::int8_t>{0, -1, 100, 0, -1, -1}));
  EXPECT_EQ(read->origin, grid.origin);
  EXPECT_EQ(read->resolution, grid.resolution);
}

TEST(GridFile, RefusesImagesThatAreCutTooLongOrNoImages) {
  const std::string pgm = grid_to_pgm(small_grid());
  const std::string yaml = grid_to_yaml(small_grid(), "grid.pgm");
  for (std::size_t size = 0; size < pgm.size(); ++size) {
    EXPECT_FALSE(grid_from_files(pgm.substr(0, size), yaml).has_value()) << size;
  }
  EXPECT_FALSE(grid_from_files(pgm + "x", yaml).has_value());
  EXPECT_FALSE(grid_from_files("P5\n99999 99999\n255\nabc", yaml).has_value());
  EXPECT_FALSE(grid_from_files("P5\n-3 2\n255\nabcdef", yaml).has_value());
  EXPECT_FALSE(grid_from_files("P6" + pgm.substr(2), yaml).has_value());
}

TEST(GridFile, RefusesImpossibleGeometry) {
  const std::string pgm = grid_to_pgm(small_grid());
  EXPECT_FALSE(grid_from_files(pgm, "resolution: 0\norigin: [0, 0, 0]\n").has_value());
  EXPECT_FALSE(grid_from_files(pgm, "resolution: .nan\norigin: [0, 0, 0]\n").has_value());
  EXPECT_FALSE(grid_from_files(pgm, "resolution: 0.05\norigin: [a, 0, 0]\n").has_value());
  EXPECT_FALSE(grid_from_files(pgm, "resolution: 0.05\n").has_value());
  EXPECT_FALSE(grid_from_files(pgm, "[").has_value());
}

}  // namespace
}  // namespace slamfuse::service
