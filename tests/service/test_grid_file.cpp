// SPDX-License-Identifier: BSD-3-Clause
#include "service/grid_file.hpp"

#include <algorithm>
#include <sstream>
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

std::string pgm_of(const common::OccupancyGrid& grid) {
  std::string pgm;
  grid_to_pgm(grid, [&](std::string_view piece) { pgm += piece; });
  return pgm;
}

common::Result<common::OccupancyGrid> read(const std::string& pgm, const std::string& yaml) {
  std::istringstream image(pgm);
  return grid_from_files(image, yaml);
}

TEST(GridFile, StartsTheImageWithTheTopRow) {
  const std::string pgm = pgm_of(small_grid());
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
  const auto back = read(pgm_of(grid), grid_to_yaml(grid, "grid.pgm"));
  ASSERT_TRUE(back.has_value()) << back.error().message;
  EXPECT_EQ(back->cells, (std::vector<std::int8_t>{0, -1, 100, 0, -1, -1}));
  EXPECT_EQ(back->origin, grid.origin);
  EXPECT_EQ(back->resolution, grid.resolution);
}

TEST(GridFile, HandsALargeImageOnInPieces) {
  common::OccupancyGrid grid = small_grid();
  grid.width = 1000;
  grid.height = 300;
  grid.cells.assign(300'000, 0);
  grid.cells[7] = 100;
  std::size_t largest = 0;
  std::string pgm;
  grid_to_pgm(grid, [&](std::string_view piece) {
    largest = std::max(largest, piece.size());
    pgm += piece;
  });
  EXPECT_LT(largest, 70'000u);
  const auto back = read(pgm, grid_to_yaml(grid, "grid.pgm"));
  ASSERT_TRUE(back.has_value()) << back.error().message;
  EXPECT_EQ(back->cells, grid.cells);
}

TEST(GridFile, RefusesImagesThatAreCutTooLongOrNoImages) {
  const std::string pgm = pgm_of(small_grid());
  const std::string yaml = grid_to_yaml(small_grid(), "grid.pgm");
  for (std::size_t size = 0; size < pgm.size(); ++size) {
    EXPECT_FALSE(read(pgm.substr(0, size), yaml).has_value()) << size;
  }
  EXPECT_FALSE(read(pgm + "x", yaml).has_value());
  EXPECT_FALSE(read("P5\n99999 99999\n255\nabc", yaml).has_value());
  EXPECT_FALSE(read("P5\n-3 2\n255\nabcdef", yaml).has_value());
  EXPECT_FALSE(read("P6" + pgm.substr(2), yaml).has_value());
}

TEST(GridFile, RefusesImpossibleGeometry) {
  const std::string pgm = pgm_of(small_grid());
  EXPECT_FALSE(read(pgm, "resolution: 0\norigin: [0, 0, 0]\n").has_value());
  EXPECT_FALSE(read(pgm, "resolution: .nan\norigin: [0, 0, 0]\n").has_value());
  EXPECT_FALSE(read(pgm, "resolution: 0.05\norigin: [a, 0, 0]\n").has_value());
  EXPECT_FALSE(read(pgm, "resolution: 0.05\n").has_value());
  EXPECT_FALSE(read(pgm, "[").has_value());
}

}  // namespace
}  // namespace slamfuse::service
