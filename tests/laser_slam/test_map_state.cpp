// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/map_state.hpp"

#include <cstring>
#include <limits>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "laser_slam/random_stream.hpp"
#include "process_meter.hpp"
#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

using ::testing::HasSubstr;

MapState room_state() {
  const auto laser = testing::full_circle_laser();
  const auto beams =
      project_scan(testing::scan_at(testing::room(), laser, 0, common::Pose2{}), laser, {}, Eigen::Vector3d::Zero());
  MapState state{{0.5, -0.25, 1.0}, 12.5, GridMap{MapOptions{}}};
  InsertionScratch scratch;
  state.map.insert(*beams, {}, 3.0, scratch);
  return state;
}

constexpr std::size_t kHeader = 24;
constexpr std::size_t kFirstPlaceAt = 5 * 8 + 4;

/// The payload of a state, uncompressed.
std::string payload_of(const std::string& bytes) {
  std::string payload(std::size_t{10} << 20, '\0');
  uLongf size = payload.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(payload.data()), &size,
                       reinterpret_cast<const Bytef*>(bytes.data()) + kHeader, bytes.size() - kHeader),
            Z_OK);
  payload.resize(size);
  return payload;
}

/// A state of a format version with this behind the header.
std::string state_of(std::uint32_t version, const std::string& body) {
  const auto text = [](auto value) { return std::string(reinterpret_cast<const char*>(&value), sizeof value); };
  const auto crc = static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(body.data()), body.size()));
  return "SFLASER1" + text(version) + text(static_cast<std::uint64_t>(body.size())) + text(crc) + body;
}

std::string compressed(const std::string& payload) {
  std::string bytes(compressBound(payload.size()), '\0');
  uLongf size = bytes.size();
  compress(reinterpret_cast<Bytef*>(bytes.data()), &size, reinterpret_cast<const Bytef*>(payload.data()),
           payload.size());
  bytes.resize(size);
  return bytes;
}

template <class T>
std::string with(std::string payload, std::size_t at, T value) {
  std::memcpy(payload.data() + at, &value, sizeof value);
  return payload;
}

std::string refusal(const std::string& bytes, const MapOptions& options = {}) {
  const auto state = parse_state(bytes, options);
  return state ? std::string() : state.error().message;
}

TEST(MapState, ComesBackAsItWas) {
  const MapState before = room_state();
  const std::string bytes = *serialize_state(before);
  const auto after = parse_state(bytes, MapOptions{});
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_EQ(after->pose.vector(), before.pose.vector());
  EXPECT_EQ(after->path_length, 12.5);
  EXPECT_EQ(*serialize_state(*after), bytes);
  const Surface wall = before.map.surface_at({-3.03, 0.0}, 2);
  ASSERT_GT(wall.weight, 0.0);
  EXPECT_EQ(after->map.surface_at({-3.03, 0.0}, 2).mean, wall.mean);
}

TEST(MapState, RefusesWhatIsCutAlteredNewerOrForeign) {
  const std::string bytes = *serialize_state(room_state());
  EXPECT_EQ(refusal(bytes), "");
  EXPECT_THAT(refusal(""), HasSubstr("SFLASER1"));
  EXPECT_THAT(refusal("P5 100 100 255 and so on and so on"), HasSubstr("SFLASER1"));
  EXPECT_THAT(refusal(bytes.substr(0, bytes.size() / 2)), HasSubstr("announced"));
  std::string altered = bytes;
  altered[bytes.size() / 2] = static_cast<char>(altered[bytes.size() / 2] ^ 1);
  EXPECT_THAT(refusal(altered), HasSubstr("checksum"));
  std::string newer = bytes;
  newer[8] = 9;
  EXPECT_THAT(refusal(newer), HasSubstr("version 9"));
}

TEST(MapState, ReadsTheUncompressedFirstVersion) {
  const std::string bytes = *serialize_state(room_state());
  const auto state = parse_state(state_of(1, payload_of(bytes)), MapOptions{});
  ASSERT_TRUE(state) << state.error().message;
  EXPECT_EQ(*serialize_state(*state), bytes);
}

TEST(MapState, IsSmallerThanItsTiles) {
  const std::string bytes = *serialize_state(room_state());
  EXPECT_LT(bytes.size(), payload_of(bytes).size() / 10);
}

/// A large map: as many tiles as corridors of 1.5 km would fill, a seventh of their cells walls.
MapState large_state() {
  MapState state{{}, 0.0, GridMap{MapOptions{}}};
  RandomStream random(3, 3);
  constexpr int kSide = 80;
  EXPECT_TRUE(state.map.tiles().include(0, 0, kSide, kSide));
  for (int i = 0; i < kSide * kSide; ++i) {
    Tile& tile = state.map.tiles().write(i % kSide, i / kSide);
    for (std::size_t cell = 0; cell < Tile::kCells; ++cell) {
      const bool wall = cell % 7 == 0;
      tile.log_odds[cell] = static_cast<std::int8_t>((wall ? -100.0 : 40.0) + 20.0 * random.uniform());
      if (!wall) continue;
      tile.endpoints[cell] = {static_cast<std::int16_t>(20000.0 * random.uniform()),
                              static_cast<std::int16_t>(20000.0 * random.uniform()),
                              static_cast<std::uint16_t>(1 + 20.0 * random.uniform()), 1000};
    }
  }
  return state;
}

TEST(MapState, IsSavedAndLoadedWithoutASecondCopyInMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers keep memory of their own";
#endif
  std::optional<MapState> state;
  const double map_bytes = measure([&] { state = large_state(); }).kept_bytes;
  ASSERT_GT(map_bytes, 50e6);
  std::string bytes;
  const WorkCost saving = measure([&] { bytes = *serialize_state(*state); });
  const double saved_bytes = static_cast<double>(bytes.size());
  EXPECT_LT(saved_bytes, 0.4 * map_bytes) << "though its numbers are random";
  EXPECT_LT(saving.peak_bytes, 3.0 * saved_bytes + 2e6) << "a string that grows, and nothing else";
  state.reset();
  const WorkCost loading = measure([&] { state = *parse_state(bytes, MapOptions{}); });
  EXPECT_LT(loading.peak_bytes, 1.05 * map_bytes + 2e6);
}

TEST(MapState, RefusesAPayloadThatIsCutAnywhereOrTooLong) {
  const std::string payload = payload_of(*serialize_state(room_state()));
  for (std::size_t size = 0; size < payload.size(); size += size < 200 ? 1 : 997) {
    EXPECT_NE(refusal(state_of(1, payload.substr(0, size))), "") << size;
    EXPECT_NE(refusal(state_of(2, compressed(payload.substr(0, size)))), "") << size;
  }
  EXPECT_THAT(refusal(state_of(1, payload + "x")), HasSubstr("left over"));
  EXPECT_THAT(refusal(state_of(2, compressed(payload + "x"))), HasSubstr("left over"));
  EXPECT_THAT(refusal(state_of(2, compressed(payload) + "x")), HasSubstr("left over"));
  EXPECT_THAT(refusal(state_of(2, payload)), HasSubstr("cannot be read"));
}

TEST(MapState, RefusesTilesThatAreTooManyTooFarOrTwiceThere) {
  const std::string payload = payload_of(*serialize_state(room_state()));
  const auto reason = [&](std::size_t at, auto value) { return refusal(state_of(1, with(payload, at, value))); };
  EXPECT_THAT(reason(kFirstPlaceAt - 4, std::uint32_t{0xffffffff}), HasSubstr("allowed are 262144"));
  EXPECT_THAT(reason(kFirstPlaceAt - 4, std::uint32_t{1000}), HasSubstr("do not fit"));
  EXPECT_THAT(reason(kFirstPlaceAt, std::int32_t{1 << 20}), HasSubstr("a tile at (1048576"));
  std::string twice = payload;
  twice.replace(kFirstPlaceAt + 8, 8, payload.substr(kFirstPlaceAt, 8));
  EXPECT_THAT(refusal(state_of(1, twice)), HasSubstr("twice"));
  const std::string apart = with(payload, kFirstPlaceAt, std::int32_t{-32000});
  EXPECT_THAT(refusal(state_of(1, with(apart, kFirstPlaceAt + 4, std::int32_t{-32000}))), HasSubstr("tiles, allowed"));
}

TEST(MapState, RefusesMillionsOfTilesInAFewCompressedBytes) {
  const std::string payload = payload_of(*serialize_state(room_state()));
  std::string bomb = with(payload.substr(0, kFirstPlaceAt), kFirstPlaceAt - 4, std::uint32_t{200'000});
  EXPECT_THAT(refusal(state_of(2, compressed(bomb))), HasSubstr("do not fit"));
}

TEST(MapState, RefusesAnotherCellSize) {
  MapOptions options;
  options.resolution = 0.1;
  EXPECT_THAT(refusal(*serialize_state(room_state()), options), HasSubstr("laser.map.resolution is 0.1"));
}

TEST(MapState, RefusesAPoseThatIsNotFinite) {
  MapState state = room_state();
  state.pose.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(*serialize_state(state)), HasSubstr("not finite"));
}

TEST(MapState, RefusesAPoseOutsideAnyMap) {
  MapState state = room_state();
  state.pose.x = 1e300;
  EXPECT_THAT(refusal(*serialize_state(state)), HasSubstr("m from the origin"));
  state = room_state();
  state.path_length = -1.0;
  EXPECT_THAT(refusal(*serialize_state(state)), HasSubstr("path length is -1"));
  state = room_state();
  state.pose.theta = 100.0;
  EXPECT_THAT(refusal(*serialize_state(state)), HasSubstr("heading"));
}

TEST(MapState, TakesAnEmptyMap) { EXPECT_EQ(refusal(*serialize_state({{}, 0.0, GridMap{MapOptions{}}})), ""); }

TEST(ToOccupancyGrid, ShowsWallsFreeSpaceAndTheUnknownWhereTheyAre) {
  const MapState state = room_state();
  const common::OccupancyGrid grid = to_occupancy_grid(state.map);
  const auto value_at = [&](double x, double y) {
    const Eigen::Vector2d cell = (Eigen::Vector2d(x, y) - grid.origin) / grid.resolution;
    return static_cast<int>(grid.at(static_cast<int>(cell.x()), static_cast<int>(cell.y())));
  };
  EXPECT_GT(value_at(-3.03, -0.01), 60);
  EXPECT_LT(value_at(1.0, 0.0), 45);
  EXPECT_EQ(value_at(2.1, 3.2), common::OccupancyGrid::kUnknown) << "inside the cupboard";
  EXPECT_EQ(grid.cells.size(), static_cast<std::size_t>(grid.width * grid.height));
}

TEST(ToOccupancyGrid, IsEmptyForAnEmptyMap) {
  const common::OccupancyGrid grid = to_occupancy_grid(GridMap{MapOptions{}});
  EXPECT_EQ(grid.width, 0);
  EXPECT_TRUE(grid.cells.empty());
}

}  // namespace
}  // namespace slamfuse::laser_slam
