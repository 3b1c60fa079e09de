// SPDX-License-Identifier: BSD-3-Clause
#include "service/nav2_map.hpp"

#include <filesystem>
#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>
#include <zlib.h>

#include "service/grid_file.hpp"
#include "service/temporary_folder.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Cells = std::vector<std::int8_t>;

/// The samples as a PNG of one row.
std::string png_of(png_uint_32 format, const std::vector<std::uint8_t>& samples) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.format = format;
  image.height = 1;
  image.width = static_cast<png_uint_32>(samples.size() / PNG_IMAGE_PIXEL_CHANNELS(format));
  std::string bytes(1000, '\0');
  png_alloc_size_t size = bytes.size();
  EXPECT_NE(png_image_write_to_memory(&image, bytes.data(), &size, 0, samples.data(), 0, nullptr), 0);
  bytes.resize(size);
  return bytes;
}

class Nav2Map : public testing::Test {
 protected:
  /// A YAML file with these keys and values.
  fs::path yaml(const std::map<std::string, std::string>& keys) const {
    std::string text = "# a map\n";
    for (const auto& [key, value] : keys) text += key + ": " + value + "\n";
    put(temporary_ / "map.yaml", text);
    return temporary_ / "map.yaml";
  }
  fs::path changed(const std::string& key, const std::string& value) const {
    auto keys = keys_;
    keys[key] = value;
    return yaml(keys);
  }
  fs::path without(const std::string& key) const {
    auto keys = keys_;
    keys.erase(key);
    return yaml(keys);
  }
  void put_image(const std::string& bytes) const { put(temporary_ / "map.pgm", bytes); }

  Cells cells(const fs::path& path) const {
    const auto grid = read_nav2_map(path);
    EXPECT_TRUE(grid.has_value()) << grid.error().message;
    return grid ? grid->cells : Cells{};
  }
  void expect_refused(const fs::path& path, const std::vector<std::string>& words) const {
    const auto grid = read_nav2_map(path);
    ASSERT_FALSE(grid.has_value());
    EXPECT_EQ(grid.error().kind, common::ErrorKind::kInvalidInput);
    EXPECT_THAT(grid.error().message, HasSubstr("map.yaml"));
    for (const std::string& word : words) EXPECT_THAT(grid.error().message, HasSubstr(word));
  }

  TemporaryFolder temporary_;
  const std::map<std::string, std::string> keys_ = {
      {"image", "map.pgm"}, {"resolution", "0.1"},       {"origin", "[-1.5, 2.25, 0.0]"},
      {"negate", "0"},      {"occupied_thresh", "0.65"}, {"free_thresh", "0.196"}};
};

TEST_F(Nav2Map, IsReadWithTheTopRowFarthestUp) {
  put_image("P5\n3 2\n255\n" + std::string("\x00\xcd\xfe\xfe\xfe\x00", 6));
  const auto grid = read_nav2_map(yaml(keys_));
  ASSERT_TRUE(grid.has_value()) << grid.error().message;
  EXPECT_EQ(grid->width, 3);
  EXPECT_EQ(grid->height, 2);
  EXPECT_EQ(grid->resolution, 0.1);
  EXPECT_EQ(grid->origin, Eigen::Vector2d(-1.5, 2.25));
  EXPECT_EQ(grid->cells, (Cells{0, 0, 100, 100, -1, 0}));
}

TEST_F(Nav2Map, IsTrinaryUnlessItSaysOtherwise) {
  put_image("P2\n# five grays\n5 1\n255\n0 89 90 205 206\n");
  const Cells trinary{100, 100, -1, -1, 0};
  EXPECT_EQ(cells(yaml(keys_)), trinary);
  EXPECT_EQ(cells(changed("mode", "trinary")), trinary);
}

TEST_F(Nav2Map, TurnsShadesRoundWithNegate) {
  put_image("P2 5 1 255 255 166 165 50 49");
  for (const char* negate : {"1", "true"}) EXPECT_EQ(cells(changed("negate", negate)), (Cells{100, 100, -1, -1, 0}));
  EXPECT_EQ(cells(changed("negate", "false")), (Cells{0, -1, -1, 100, 100}));
}

TEST_F(Nav2Map, InModeScaleIsInProportionBetweenTheThresholds) {
  put_image("P2 5 1 255 0 90 147 205 255");
  // (1 - 90/255 - 0.196) / 0.454 and so on
  EXPECT_EQ(cells(changed("mode", "scale")), (Cells{100, 99, 50, 0, 0}));
}

TEST_F(Nav2Map, InModeRawTakesTheNumbersAsTheyAre) {
  put_image("P2 5 1 255 0 37 100 101 255");
  auto keys = keys_;
  keys["mode"] = "raw";
  keys["negate"] = "1";
  EXPECT_EQ(cells(yaml(keys)), (Cells{0, 37, 100, -1, -1}));
}

TEST_F(Nav2Map, TakesPnmOfAnyMaximumWithComments) {
  for (const std::string& image :
       {std::string("P5\n# saved by hand\n3 1\n# white:\n100\n") + std::string("\x00\x51\x64", 3),
        std::string("P2 3 1 1000 0 810 1000"), std::string("P3 3 1 9 0 0 0 7 7 7 9 9 9"),
        std::string("P6 3 1 255\n") + std::string("\x00\x00\x00\xcd\xcd\xcd\xff\xff\xff", 9)}) {
    put_image(image);
    const Cells read = cells(changed("free_thresh", "0.15"));
    EXPECT_EQ(read, (Cells{100, -1, 0})) << image;
  }
}

TEST_F(Nav2Map, TakesEveryKindOfPng) {
  const Cells expected{100, -1, 0};
  put_image(png_of(PNG_FORMAT_GRAY, {0, 205, 254}));
  EXPECT_EQ(cells(yaml(keys_)), expected);
  put_image(png_of(PNG_FORMAT_RGB, {0, 0, 0, 205, 205, 205, 254, 254, 254}));
  EXPECT_EQ(cells(yaml(keys_)), expected);
  put_image(png_of(PNG_FORMAT_RGB, {30, 0, 9, 255, 255, 105, 255, 255, 252}));
  EXPECT_EQ(cells(yaml(keys_)), expected) << "the mean of the colours, none weighs more";
}

TEST_F(Nav2Map, TakesAPngWithAPaletteAndATransparentColour) {
  // 3 x 1 pixels of two bits: colours 0, 1, 2; colour 1 is half transparent.
  const auto chunk = [](const std::string& body) {
    const auto word = [](std::uint32_t value) {
      return std::string{static_cast<char>(value >> 24), static_cast<char>(value >> 16), static_cast<char>(value >> 8),
                         static_cast<char>(value)};
    };
    const auto crc = crc32_z(0, reinterpret_cast<const Bytef*>(body.data()), body.size());
    return word(static_cast<std::uint32_t>(body.size() - 4)) + body + word(static_cast<std::uint32_t>(crc));
  };
  const std::string row("\x00\x18", 2);
  std::string data(100, '\0');
  uLongf size = data.size();
  compress(reinterpret_cast<Bytef*>(data.data()), &size, reinterpret_cast<const Bytef*>(row.data()), row.size());
  data.resize(size);
  put_image(std::string("\x89PNG\r\n\x1a\n", 8) + chunk(std::string("IHDR\0\0\0\x03\0\0\0\x01\x02\x03\0\0\0", 17)) +
            chunk(std::string("PLTE\0\0\0\xff\xff\xff\xfe\xfe\xfe", 13)) + chunk("tRNS\xff\x80") +
            chunk("IDAT" + data) + chunk("IEND"));
  EXPECT_EQ(cells(changed("mode", "scale")), (Cells{100, -1, 0}));
}

TEST_F(Nav2Map, TakesTransparencyAsNav2Does) {
  const std::vector<std::uint8_t> pixels{0, 0,   0,   255, 255, 255, 255, 255,  // opaque
                                         0, 0,   0,   0,   255, 255, 255, 0,    // transparent
                                         0, 254, 254, 254};
  put_image(png_of(PNG_FORMAT_RGBA, pixels));
  EXPECT_EQ(cells(changed("mode", "scale")), (Cells{100, 0, -1, -1, -1}));
  EXPECT_EQ(cells(yaml(keys_)), (Cells{100, 0, 100, -1, -1})) << "the mean of colours and opacity";
  put_image(png_of(PNG_FORMAT_GA, {0, 255, 255, 255, 0, 0, 255, 0, 254, 254}));
  EXPECT_EQ(cells(changed("mode", "scale")), (Cells{100, 0, -1, -1, -1}));
  EXPECT_EQ(cells(yaml(keys_)), (Cells{100, 0, 100, -1, 0})) << "gray is three colours";
}

TEST_F(Nav2Map, FindsItsImageBesideTheYamlAndByItsFullPath) {
  fs::create_directories(temporary_ / "pictures");
  put(temporary_ / "pictures/a map.pgm", "P2 1 1 255 0");
  EXPECT_EQ(cells(changed("image", "pictures/a map.pgm")), (Cells{100}));
  EXPECT_EQ(cells(changed("image", (temporary_ / "pictures/a map.pgm").string())), (Cells{100}));
  expect_refused(changed("image", "elsewhere.pgm"), {"elsewhere.pgm", "missing"});
}

TEST_F(Nav2Map, NamesTheKeyThatIsMissing) {
  put_image("P2 1 1 255 0");
  for (const auto& [key, value] : keys_) expect_refused(without(key), {"'" + key + "' is missing", "allowed is"});
}

TEST_F(Nav2Map, NamesTheValueThatIsWrongAndWhatIsAllowed) {
  put_image("P2 1 1 255 0");
  expect_refused(changed("image", "''"), {"'image' is empty"});
  expect_refused(changed("mode", "quaternary"), {"'mode' is quaternary", "trinary, scale or raw"});
  expect_refused(changed("resolution", "-0.05"), {"'resolution' is -0.05", "0.0001 to 1000 m"});
  expect_refused(changed("resolution", "fine"), {"'resolution' is fine"});
  expect_refused(changed("resolution", ".nan"), {"'resolution' is .nan"});
  expect_refused(changed("origin", "[0, 0]"), {"'origin' is [0, 0]", "[x, y, 0]"});
  expect_refused(changed("origin", "[0, .inf, 0]"), {"'origin' is"});
  expect_refused(changed("origin", "[0, 0, 1.57]"), {"'origin' is [0, 0, 1.57]", "turned"});
  expect_refused(changed("negate", "maybe"), {"'negate' is maybe", "0 or 1"});
  expect_refused(changed("occupied_thresh", "65"), {"'occupied_thresh' is 65", "0 to 1"});
  expect_refused(changed("free_thresh", "0.65"), {"'free_thresh' is 0.65", "less than occupied_thresh, which is 0.65"});
}

TEST_F(Nav2Map, RefusesWhatIsNoYamlOrNoImage) {
  put(temporary_ / "map.yaml", "[");
  expect_refused(temporary_ / "map.yaml", {});
  put(temporary_ / "map.yaml", "just words");
  expect_refused(temporary_ / "map.yaml", {});
  put(temporary_ / "map.yaml", std::string(2'000'000, '#'));
  expect_refused(temporary_ / "map.yaml", {"2000000 bytes"});
  for (const std::string& image :
       {std::string(), std::string("GIF89a"), std::string("P5 9 9 255 abc"), std::string("P5\n99999 99999\n255\nabc"),
        png_of(PNG_FORMAT_RGBA, std::vector<std::uint8_t>(40, 7)).substr(0, 60)}) {
    put_image(image);
    expect_refused(yaml(keys_), {"map.pgm"});
  }
}

TEST_F(Nav2Map, IsRecognisedByItsKeys) {
  EXPECT_TRUE(is_nav2_map(yaml(keys_)));
  EXPECT_FALSE(is_nav2_map(without("image")));
  EXPECT_FALSE(is_nav2_map(temporary_ / "nothing.yaml"));
  put(temporary_ / "map.yaml", "[");
  EXPECT_FALSE(is_nav2_map(temporary_ / "map.yaml"));
}

TEST_F(Nav2Map, OfOursGivesTheSameCellsToNav2) {
  common::OccupancyGrid grid{0.05, 3, 2, {-1.5, 2.25}, {0, -1, 100, 10, -1, 90}};
  std::string pgm;
  grid_to_pgm(grid, [&](std::string_view piece) { pgm += piece; });
  put(temporary_ / "grid.pgm", pgm);
  put(temporary_ / "grid.yaml", grid_to_yaml(grid, "grid.pgm"));
  const auto read = read_nav2_map(temporary_ / "grid.yaml");
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(read->cells, (Cells{0, -1, 100, 0, -1, 100}));
  EXPECT_EQ(read->origin, grid.origin);
}

}  // namespace
}  // namespace slamfuse::service
