// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/map_state.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

namespace slamfuse::laser_slam {
namespace {

constexpr char kMagic[] = "SFLASER1";
constexpr std::size_t kMagicSize = sizeof(kMagic) - 1;
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kHeaderSize = kMagicSize + 2 * sizeof(std::uint32_t) + sizeof(std::uint64_t);
constexpr std::int32_t kMaxTileCoordinate = 1 << 15;  // 50 km at 5 cm
constexpr std::size_t kTileBytes = 2 * sizeof(std::int32_t) + Tile::kCells * (sizeof(std::int8_t) + 8);

std::uint32_t checksum(const std::string& bytes, std::size_t from) {
  uLong crc = crc32(0, nullptr, 0);
  constexpr std::size_t kChunk = 1u << 30;  // zlib counts in 32 bits
  for (std::size_t at = from; at < bytes.size(); at += kChunk) {
    crc = crc32(crc, reinterpret_cast<const Bytef*>(bytes.data() + at),
                static_cast<uInt>(std::min(kChunk, bytes.size() - at)));
  }
  return static_cast<std::uint32_t>(crc);
}

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
T read_at(const std::string& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

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
  archive.WriteBuffer(tile.log_odds.data(), tile.log_odds.size());
  for (const Endpoints& ends : tile.endpoints) archive << ends.offset_x << ends.offset_y << ends.hits << ends.last_path;
}

void read_tile(mrpt::serialization::CArchive& archive, Tile& tile, std::int8_t occupied_below) {
  archive.ReadBuffer(tile.log_odds.data(), tile.log_odds.size());
  for (std::size_t i = 0; i < tile.endpoints.size(); ++i) {
    Endpoints& ends = tile.endpoints[i];
    archive >> ends.offset_x >> ends.offset_y >> ends.hits >> ends.last_path;
    if (ends.hits > 0 && tile.log_odds[i] < occupied_below) {
      tile.occupied[i / Tile::kSide] |= 1u << (i % Tile::kSide);
    }
  }
}

common::Result<MapState> parse_payload(const std::string& bytes, const MapOptions& options) {
  mrpt::io::CMemoryStream stream;
  stream.assignMemoryNotOwn(bytes.data() + kHeaderSize, bytes.size() - kHeaderSize);
  auto archive = mrpt::serialization::archiveFrom(stream);
  MapState state{{}, 0.0, GridMap(options)};
  double resolution = 0.0;
  std::uint32_t count = 0;
  archive >> state.pose.x >> state.pose.y >> state.pose.theta >> state.path_length >> resolution >> count;
  if (!state.pose.is_finite() || !std::isfinite(state.path_length)) {
    return common::invalid_input("laser state: the pose or path length is not finite");
  }
  if (std::hypot(state.pose.x, state.pose.y) > GridMap::kFarthest) {
    return common::invalid_input(
        fmt::format("laser state: its pose is at ({}, {}), allowed is up to {} m from the origin", state.pose.x,
                    state.pose.y, GridMap::kFarthest));
  }
  if (std::abs(state.pose.theta) > std::numbers::pi) {
    return common::invalid_input(
        fmt::format("laser state: its heading is {} rad, allowed is -pi to pi", state.pose.theta));
  }
  if (resolution != options.resolution) {
    return common::invalid_input(
        fmt::format("laser state: its cells are {} m, laser.map.resolution is {} m; allowed is the same", resolution,
                    options.resolution));
  }
  if (count > (bytes.size() - kHeaderSize) / kTileBytes) {
    return common::invalid_input(fmt::format("laser state: {} tiles do not fit its {} bytes", count, bytes.size()));
  }
  std::vector<std::pair<std::int32_t, std::int32_t>> places(count);
  std::int32_t low_x = kMaxTileCoordinate, low_y = kMaxTileCoordinate;
  std::int32_t high_x = -kMaxTileCoordinate, high_y = -kMaxTileCoordinate;
  for (auto& [x, y] : places) {
    archive >> x >> y;
    if (std::abs(std::int64_t{x}) > kMaxTileCoordinate || std::abs(std::int64_t{y}) > kMaxTileCoordinate) {
      return common::invalid_input(fmt::format("laser state: a tile at ({}, {}), allowed is up to {} from the origin",
                                               x, y, kMaxTileCoordinate));
    }
    low_x = std::min(low_x, x);
    low_y = std::min(low_y, y);
    high_x = std::max(high_x, x);
    high_y = std::max(high_y, y);
  }
  if (count > 0) {
    if (!state.map.tiles().include(low_x, low_y, high_x, high_y)) {
      return common::invalid_input(fmt::format("laser state: its map is {} x {} tiles, allowed are {} in all",
                                               high_x - low_x + 1, high_y - low_y + 1, TileGrid::kMaxTiles));
    }
  }
  for (const auto& [x, y] : places) read_tile(archive, state.map.tiles().write(x, y), state.map.occupied_below());
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

std::string serialize_state(const MapState& state) {
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << state.pose.x << state.pose.y << state.pose.theta << state.path_length << state.map.resolution();
  archive << static_cast<std::uint32_t>(state.map.tiles().count());
  for_each_tile(state.map.tiles(), [&](int x, int y, const Tile&) {
    archive << static_cast<std::int32_t>(x) << static_cast<std::int32_t>(y);
  });
  for_each_tile(state.map.tiles(), [&](int, int, const Tile& tile) { write_tile(archive, tile); });

  const auto payload_size = static_cast<std::size_t>(stream.getTotalBytesCount());
  std::string payload(static_cast<const char*>(stream.getRawBufferData()), payload_size);
  std::string bytes(kMagic, kMagicSize);
  append(bytes, kVersion);
  append(bytes, static_cast<std::uint64_t>(payload_size));
  append(bytes, checksum(payload, 0));
  return bytes + payload;
}

common::Result<MapState> parse_state(const std::string& bytes, const MapOptions& options) {
  if (bytes.size() < kHeaderSize || bytes.compare(0, kMagicSize, kMagic) != 0) {
    return common::invalid_input("laser state: it does not begin with " + std::string(kMagic));
  }
  const auto version = read_at<std::uint32_t>(bytes, kMagicSize);
  if (version != kVersion) {
    return common::invalid_input(
        fmt::format("laser state: format version {}, this program reads {}", version, kVersion));
  }
  const auto size = read_at<std::uint64_t>(bytes, kMagicSize + sizeof version);
  if (size != bytes.size() - kHeaderSize) {
    return common::invalid_input(
        fmt::format("laser state: {} bytes announced, {} there", size, bytes.size() - kHeaderSize));
  }
  if (read_at<std::uint32_t>(bytes, kMagicSize + sizeof version + sizeof size) != checksum(bytes, kHeaderSize)) {
    return common::invalid_input("laser state: the checksum does not match, it was altered");
  }
  try {
    return parse_payload(bytes, options);
  } catch (const std::exception& error) {
    return common::invalid_input(std::string("laser state: cannot be read: ") + error.what());
  }
}

}  // namespace slamfuse::laser_slam
