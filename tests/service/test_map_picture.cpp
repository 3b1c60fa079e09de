// SPDX-License-Identifier: BSD-3-Clause
#include "service/map_picture.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "service/grid_png.hpp"
#include "service/markup_checks.hpp"

namespace slamfuse::service {
namespace {

using testing::HasSubstr;
using testing::Not;

common::OccupancyGrid unknown_grid(int width, int height) {
  common::OccupancyGrid grid;
  grid.resolution = 0.1;
  grid.width = width;
  grid.height = height;
  grid.origin = {-1.0, 2.0};
  grid.cells.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                    common::OccupancyGrid::kUnknown);
  return grid;
}

void set(common::OccupancyGrid& grid, int column, int row, std::int8_t value) {
  grid.cells[static_cast<std::size_t>(row * grid.width + column)] = value;
}

cv::Mat4b decode(const std::string& base64) {
  const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : base64) {
    if (c == '=') break;
    bits = (bits << 6U) | static_cast<std::uint32_t>(alphabet.find(c));
    count += 6;
    if (count >= 8) bytes.push_back(static_cast<std::uint8_t>(bits >> (count -= 8)));
  }
  return cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
}

TEST(ToBase64, FollowsTheVectorsOfRfc4648) {
  EXPECT_EQ(to_base64(""), "");
  EXPECT_EQ(to_base64("f"), "Zg==");
  EXPECT_EQ(to_base64("fo"), "Zm8=");
  EXPECT_EQ(to_base64("foo"), "Zm9v");
  EXPECT_EQ(to_base64("foobar"), "Zm9vYmFy");
}

TEST(GridToPng, ShowsTheKnownPartWithYUp) {
  auto grid = unknown_grid(20, 30);
  set(grid, 5, 10, 0);    // lower left: free
  set(grid, 6, 11, 100);  // upper right: occupied
  const auto png = grid_to_png(grid, 100);
  ASSERT_TRUE(png);
  EXPECT_DOUBLE_EQ(png->x_min, -0.5);
  EXPECT_DOUBLE_EQ(png->x_max, -0.3);
  EXPECT_DOUBLE_EQ(png->y_min, 3.0);
  EXPECT_DOUBLE_EQ(png->y_max, 3.2);
  const cv::Mat4b image = decode(png->base64);
  ASSERT_EQ(image.size(), cv::Size(2, 2));
  EXPECT_EQ(image(1, 0), cv::Vec4b(255, 255, 255, 255));
  EXPECT_EQ(image(0, 1), cv::Vec4b(0, 0, 0, 255));
  EXPECT_EQ(image(0, 0)[3], 0) << "unknown is transparent";
}

TEST(GridToPng, ThinsLargeGridsButKeepsTheirWalls) {
  auto grid = unknown_grid(1000, 400);
  for (auto& cell : grid.cells) cell = 0;
  for (int row = 0; row < 400; ++row) set(grid, 501, row, 100);
  const auto png = grid_to_png(grid, 300);
  const cv::Mat4b image = decode(png->base64);
  EXPECT_EQ(image.size(), cv::Size(250, 100));
  EXPECT_EQ(image(50, 125)[0], 0);
  EXPECT_EQ(image(50, 124)[0], 255);
}

TEST(GridToPng, IsNothingForAnUnknownOrEmptyGrid) {
  EXPECT_FALSE(grid_to_png(unknown_grid(10, 10), 100));
  EXPECT_FALSE(grid_to_png(common::OccupancyGrid(), 100));
}

common::Trajectory2 walk(std::size_t poses) {
  common::Trajectory2 path;
  for (std::size_t i = 0; i < poses; ++i) {
    path.push_back({static_cast<common::Nanoseconds>(i), {0.01 * static_cast<double>(i), 1.0, 0.0}});
  }
  return path;
}

TEST(MapPicture, DrawsGridPathsAndLandmarks) {
  auto grid = unknown_grid(50, 50);
  set(grid, 3, 3, 100);
  MapPicture picture;
  picture.grid = &grid;
  picture.paths = {{"laser <1>", "laser", walk(100)}};
  picture.landmarks = {{0.1, 1.0}};
  const std::string svg = map_picture(picture);
  EXPECT_EQ(nesting_fault(svg), "");
  EXPECT_THAT(svg, HasSubstr("data:image/png;base64,"));
  EXPECT_THAT(svg, HasSubstr("line laser"));
  EXPECT_THAT(svg, HasSubstr("laser &lt;1&gt;"));
  EXPECT_THAT(svg, HasSubstr("dots landmark"));
  EXPECT_THAT(svg, HasSubstr("x [m]"));
}

TEST(MapPicture, IsEmptyWithNothingToDraw) {
  const auto grid = unknown_grid(5, 5);
  MapPicture picture;
  picture.grid = &grid;
  picture.paths = {{"laser", "laser", {}}};
  picture.landmarks = {{1.0, 1.0}};
  EXPECT_EQ(map_picture(picture), "");
}

TEST(MapPicture, DoesNotShrinkThePlanForAFarLandmarkNorDrawIt) {
  MapPicture picture;
  picture.paths = {{"laser", "laser", walk(100)}};
  const std::string without = map_picture(picture);
  picture.landmarks = {{1e6, 1e6}};
  const std::string with = map_picture(picture);
  EXPECT_THAT(with, Not(HasSubstr("dots landmark")));
  EXPECT_EQ(with.substr(0, with.find('>')), without.substr(0, without.find('>')));
}

TEST(MapPicture, DrawsARobotThatNeverMoved) {
  MapPicture picture;
  picture.paths = {{"laser", "laser", {{0, {1.0, 2.0, 0.0}}}}};
  const std::string svg = map_picture(picture);
  EXPECT_THAT(svg, HasSubstr("<circle"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

TEST(MapPicture, StaysSmallForLongPaths) {
  MapPicture picture;
  picture.paths = {{"laser", "laser", walk(500000)}};
  EXPECT_LT(map_picture(picture).size(), 40000u);
}

TEST(MapPictureFile, BringsItsOwnStyleSheet) {
  MapPicture picture;
  picture.paths = {{"laser", "laser", walk(10)}};
  const std::string file = map_picture_file(picture);
  EXPECT_TRUE(file.starts_with("<?xml"));
  EXPECT_THAT(file, HasSubstr("<style>"));
  EXPECT_EQ(nesting_fault(file), "");
}

}  // namespace
}  // namespace slamfuse::service
