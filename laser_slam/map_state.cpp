// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/map_state.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

#include "laser_slam/zlib_stream.hpp"

namespace slamfuse::laser_slam {
namespace {

static_assert(std::endian::native == std::endian::little, "the bytes are written as they lie in memory");

constexpr std::string_view kMagic = "SFLASER1";
constexpr std::uint32_t kVersion = 2;
constexpr std::uint32_t kUncompressedVersion = 1;
constexpr std::size_t kHeaderSize = kMagic.size() + 2 * sizeof(std::uint32_t) + sizeof(std::uint64_t);
constexpr std::int32_t kMaxTileCoordinate = 1 << 15;  // 50 km at 5 cm
constexpr std::size_t kPlaceBytes = 2 * sizeof(std::int32_t);
constexpr std::size_t kTileBytes = sizeof(Tile::log_odds) + sizeof(Tile::endpoints);
static_assert(sizeof(Endpoints) == 4 * sizeof(std::int16_t));
constexpr std::size_t kFixedBytes = 5 * sizeof(double) + sizeof(std::uint32_t);  // of the payload, before the tiles
constexpr std::size_t kCompressionAtMost = 1032;                                 // deflate's largest possible ratio

tl::unexpected<common::Error> refused(const std::string& reason) {
  return common::invalid_input("laser state: " + reason);
}

std::uint32_t checksum(std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

template <class T>
T get(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

constexpr std::size_t kVersionAt = kMagic.size();
constexpr std::size_t kLengthAt = kVersionAt + sizeof(std::uint32_t);
constexpr std::size_t kChecksumAt = kLengthAt + sizeof(std::uint64_t);

/// Calls visit(tile x, tile y, tile) for every tile that exists, row by row.
template <class Visit>
void for_each_tile(const TileGrid& tiles, const Visit& visit) {
  for (int y = tiles.min_y(); y < tiles.min_y() + tiles.height(); ++y) {
    for (int x = tiles.min_x(); x < tiles.min_x() + tiles.width(); ++x) {
      if (const Tile* tile = tiles.find(x, y)) visit(x, y, *tile);
    }
  }
}

void write_tile(mrpt::serialization::CArchive& archive, const Tile& tile) {
  archive.WriteBuffer(tile.log_odds.data(), sizeof tile.log_odds);
  archive.WriteBuffer(tile.endpoints.data(), sizeof tile.endpoints);
}

void read_tile(mrpt::serialization::CArchive& archive, Tile& tile, std::int8_t occupied_below) {
  archive.ReadBuffer(tile.log_odds.data(), sizeof tile.log_odds);
  archive.ReadBuffer(tile.endpoints.data(), sizeof tile.endpoints);
  for (std::size_t i = 0; i < tile.endpoints.size(); ++i) {
    if (tile.endpoints[i].hits > 0 && tile.log_odds[i] < occupied_below) {
      tile.occupied[i / Tile::kSide] |= 1u << (i % Tile::kSide);
    }
  }
}

void write_payload(mrpt::serialization::CArchive& archive, const MapState& state, std::uint32_t count) {
  archive << state.pose.x << state.pose.y << state.pose.theta << state.path_length << state.map.resolution() << count;
  for_each_tile(state.map.tiles(), [&](int x, int y, const Tile&) {
    archive << static_cast<std::int32_t>(x) << static_cast<std::int32_t>(y);
  });
  for_each_tile(state.map.tiles(), [&](int, int, const Tile& tile) { write_tile(archive, tile); });
}

common::Result<void> check_numbers(const MapState& state, double resolution, const MapOptions& options) {
  if (!state.pose.is_finite() || !std::isfinite(state.path_length)) {
    return refused("the pose or path length is not finite");
  }
  if (state.path_length < 0.0) {
    return refused(fmt::format("its path length is {} m, allowed is 0 or more", state.path_length));
  }
  if (std::hypot(state.pose.x, state.pose.y) > GridMap::kFarthest) {
    return refused(fmt::format("its pose is at ({}, {}), allowed is up to {} m from the origin", state.pose.x,
                               state.pose.y, GridMap::kFarthest));
  }
  if (std::abs(state.pose.theta) > std::numbers::pi) {
    return refused(fmt::format("its heading is {} rad, allowed is -pi to pi", state.pose.theta));
  }
  if (resolution != options.resolution) {
    return refused(fmt::format("its cells are {} m, laser.map.resolution is {} m; allowed is the same", resolution,
                               options.resolution));
  }
  return {};
}

/// Where a tile is, in the order of for_each_tile().
struct Place {
  std::int32_t x = 0;
  std::int32_t y = 0;
  bool is_before(const Place& other) const { return std::pair(y, x) < std::pair(other.y, other.x); }
};

/// Reads the places of the tiles and makes room for them in the map.
common::Result<std::vector<Place>> read_places(mrpt::serialization::CArchive& archive, std::uint32_t count,
                                               TileGrid& tiles) {
  std::vector<Place> places(count);
  Place low{kMaxTileCoordinate, kMaxTileCoordinate};
  Place high{-kMaxTileCoordinate, -kMaxTileCoordinate};
  for (std::size_t i = 0; i < places.size(); ++i) {
    Place& place = places[i];
    archive >> place.x >> place.y;
    if (std::abs(std::int64_t{place.x}) > kMaxTileCoordinate || std::abs(std::int64_t{place.y}) > kMaxTileCoordinate) {
      return refused(
          fmt::format("a tile at ({}, {}), allowed is up to {} from the origin", place.x, place.y, kMaxTileCoordinate));
    }
    if (i > 0 && !places[i - 1].is_before(place)) {
      return refused(fmt::format("the tile at ({}, {}) comes twice or out of order", place.x, place.y));
    }
    low = {std::min(low.x, place.x), std::min(low.y, place.y)};
    high = {std::max(high.x, place.x), std::max(high.y, place.y)};
  }
  if (count > 0 && !tiles.include(low.x, low.y, high.x, high.y)) {
    return refused(fmt::format("its map is {} x {} tiles, allowed are {} in all", high.x - low.x + 1,
                               high.y - low.y + 1, TileGrid::kMaxTiles));
  }
  return places;
}

/// `most_bytes`: the payload cannot be longer.
common::Result<MapState> read_payload(mrpt::io::CStream& stream, std::size_t most_bytes, const MapOptions& options) {
  auto archive = mrpt::serialization::archiveFrom(stream);
  MapState state{{}, 0.0, GridMap(options)};
  double resolution = 0.0;
  std::uint32_t count = 0;
  archive >> state.pose.x >> state.pose.y >> state.pose.theta >> state.path_length >> resolution >> count;
  if (auto checked = check_numbers(state, resolution, options); !checked) return tl::unexpected(checked.error());
  if (count > kMaxSavedTiles) return refused(fmt::format("{} tiles, allowed are {}", count, kMaxSavedTiles));
  if (kFixedBytes + count * (kPlaceBytes + kTileBytes) > most_bytes) {
    return refused(fmt::format("{} tiles do not fit its bytes", count));
  }
  const auto places = read_places(archive, count, state.map.tiles());
  if (!places) return tl::unexpected(places.error());
  for (const Place& place : *places) {
    read_tile(archive, state.map.tiles().write(place.x, place.y), state.map.occupied_below());
  }
  return state;
}

common::Result<MapState> read_compressed(std::string_view bytes, const MapOptions& options) {
  InflateStream stream(bytes);
  auto state = read_payload(stream, bytes.size() * kCompressionAtMost, options);
  if (state && !stream.at_end()) return refused("there are bytes left over");
  return state;
}

common::Result<MapState> read_uncompressed(std::string_view bytes, const MapOptions& options) {
  mrpt::io::CMemoryStream stream;
  stream.assignMemoryNotOwn(bytes.data(), bytes.size());
  auto state = read_payload(stream, bytes.size(), options);
  if (state && stream.getPosition() != bytes.size()) return refused("there are bytes left over");
  return state;
}

}  // namespace

common::OccupancyGrid to_occupancy_grid(const GridMap& map) {
  common::OccupancyGrid grid;
  grid.resolution = map.resolution();
  int low_x = std::numeric_limits<int>::max(), low_y = low_x;
  int high_x = std::numeric_limits<int>::min(), high_y = high_x;
  const auto for_each_seen = [&](const auto& visit) {
    for_each_tile(map.tiles(), [&](int tile_x, int tile_y, const Tile& tile) {
      for (int i = 0; i < Tile::kCells; ++i) {
        const std::int8_t value = tile.log_odds[static_cast<std::size_t>(i)];
        if (value != 0) visit(tile_x * Tile::kSide + i % Tile::kSide, tile_y * Tile::kSide + i / Tile::kSide, value);
      }
    });
  };
  for_each_seen([&](int x, int y, std::int8_t) {
    low_x = std::min(low_x, x);
    low_y = std::min(low_y, y);
    high_x = std::max(high_x, x);
    high_y = std::max(high_y, y);
  });
  if (low_x > high_x) return grid;
  grid.width = high_x - low_x + 1;
  grid.height = high_y - low_y + 1;
  grid.origin = Eigen::Vector2d(low_x, low_y) * grid.resolution;
  grid.cells.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height),
                    common::OccupancyGrid::kUnknown);
  for_each_seen([&](int x, int y, std::int8_t value) {
    const auto cell = static_cast<std::size_t>(y - low_y) * static_cast<std::size_t>(grid.width) +
                      static_cast<std::size_t>(x - low_x);
    const float free = mrpt::maps::COccupancyGridMap2D::l2p(value);
    grid.cells[cell] = static_cast<std::int8_t>(std::lround(100.0f * (1.0f - free)));
  });
  return grid;
}

common::Result<std::string> serialize_state(const MapState& state) {
  const std::size_t count = state.map.tiles().count();
  if (count > kMaxSavedTiles) {
    return common::failed(
        fmt::format("laser state: the map has {} tiles, up to {} can be saved", count, kMaxSavedTiles));
  }
  std::string bytes(kMagic);
  bytes.resize(kHeaderSize);
  DeflateStream stream(bytes);
  auto archive = mrpt::serialization::archiveFrom(stream);
  write_payload(archive, state, static_cast<std::uint32_t>(count));
  stream.finish();
  const std::string_view payload = std::string_view(bytes).substr(kHeaderSize);
  put(bytes, kVersionAt, kVersion);
  put(bytes, kLengthAt, static_cast<std::uint64_t>(payload.size()));
  put(bytes, kChecksumAt, checksum(payload));
  return bytes;
}

common::Result<MapState> parse_state(std::string_view bytes, const MapOptions& options) {
  if (bytes.size() < kHeaderSize || !bytes.starts_with(kMagic)) {
    return refused(fmt::format("it does not begin with {}", kMagic));
  }
  const auto version = get<std::uint32_t>(bytes, kVersionAt);
  if (version != kVersion && version != kUncompressedVersion) {
    return refused(
        fmt::format("format version {}, this program reads {} and {}", version, kUncompressedVersion, kVersion));
  }
  const std::string_view payload = bytes.substr(kHeaderSize);
  const auto length = get<std::uint64_t>(bytes, kLengthAt);
  if (length != payload.size()) {
    return refused(fmt::format("{} bytes announced, {} there", length, payload.size()));
  }
  if (get<std::uint32_t>(bytes, kChecksumAt) != checksum(payload)) {
    return refused("the checksum does not match, it was altered");
  }
  try {
    return version == kVersion ? read_compressed(payload, options) : read_uncompressed(payload, options);
  } catch (const std::exception& error) {
    return refused(std::string("cannot be read: ") + error.what());
  }
}

}  // namespace slamfuse::laser_slam
