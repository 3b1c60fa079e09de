// SPDX-License-Identifier: BSD-3-Clause
#include "service/grid_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <vector>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

namespace slamfuse::service {
namespace {

/// Cells at least this likely occupied are written as occupied, at most that likely as free [percent].
constexpr int kOccupiedPercent = 65;
constexpr int kFreePercent = 25;
/// The grays ROS's map savers write, and thresholds with which the server reads back the same three states: gray 205
/// is an occupancy of 0.1961, so Nav2's default free_thresh of 0.25 would turn the unknown free.
constexpr double kOccupiedThreshold = 0.65;
constexpr double kFreeThreshold = 0.196;
constexpr char kOccupiedGray = 0;
constexpr auto kUnknownGray = static_cast<char>(205);
constexpr auto kFreeGray = static_cast<char>(254);
constexpr int kWhite = 255;
/// Rows are handed on in pieces of about this size.
constexpr std::size_t kPiece = std::size_t{1} << 16;
/// Refuses sizes that can only be an accident (3.3 km at 5 cm).
constexpr int kMaxSide = 65535;

char gray_of(std::int8_t cell) {
  if (cell < 0) return kUnknownGray;
  if (cell >= kOccupiedPercent) return kOccupiedGray;
  if (cell <= kFreePercent) return kFreeGray;
  return kUnknownGray;
}

std::int8_t cell_of(int gray) {
  const double occupancy = static_cast<double>(kWhite - gray) / kWhite;
  if (occupancy > kOccupiedThreshold) return 100;
  if (occupancy < kFreeThreshold) return 0;
  return common::OccupancyGrid::kUnknown;
}

tl::unexpected<common::Error> refused(const std::string& reason) { return common::invalid_input("grid: " + reason); }

/// How many bytes are left to read.
std::uintmax_t bytes_left(std::istream& stream) {
  const auto here = stream.tellg();
  stream.seekg(0, std::ios::end);
  const auto end = stream.tellg();
  stream.seekg(here);
  return stream ? static_cast<std::uintmax_t>(end - here) : 0;
}

/// Reads the image's head and gives the grid its size.
common::Result<void> read_head(std::istream& pgm, common::OccupancyGrid& grid) {
  std::array<char, 2> magic{};
  if (!pgm.read(magic.data(), magic.size()) || magic != std::array<char, 2>{'P', '5'}) {
    return refused("the image is not a binary PGM");
  }
  int depth = 0;
  pgm >> grid.width >> grid.height >> depth;
  const auto side_is_good = [](int side) { return side >= 0 && side <= kMaxSide; };
  if (!pgm || !side_is_good(grid.width) || !side_is_good(grid.height) || depth != kWhite) {
    return refused(fmt::format("the PGM header must give two sides up to {} and {} grays", kMaxSide, kWhite));
  }
  pgm.ignore();
  const std::uintmax_t cells = static_cast<std::uintmax_t>(grid.width) * static_cast<std::uintmax_t>(grid.height);
  const std::uintmax_t bytes = bytes_left(pgm);
  if (bytes != cells) {
    return refused(fmt::format("{}x{} pixels need {} bytes, there are {}", grid.width, grid.height, cells, bytes));
  }
  return {};
}

/// Reads the rows, of which the file has the top one first.
common::Result<void> read_rows(std::istream& pgm, common::OccupancyGrid& grid) {
  const auto width = static_cast<std::size_t>(grid.width);
  std::array<std::int8_t, kWhite + 1> cells{};
  for (std::size_t gray = 0; gray < cells.size(); ++gray) cells[gray] = cell_of(static_cast<int>(gray));
  std::vector<char> pixels(width);
  grid.cells.resize(width * static_cast<std::size_t>(grid.height));
  for (auto row = static_cast<std::size_t>(grid.height); row-- > 0;) {
    if (!pgm.read(pixels.data(), static_cast<std::streamsize>(width))) return refused("the image cannot be read");
    std::transform(pixels.begin(), pixels.end(), grid.cells.begin() + static_cast<std::ptrdiff_t>(row * width),
                   [&](char pixel) { return cells[static_cast<unsigned char>(pixel)]; });
  }
  return {};
}

}  // namespace

void grid_to_pgm(const common::OccupancyGrid& grid, const std::function<void(std::string_view)>& take) {
  std::string piece = fmt::format("P5\n{} {}\n{}\n", grid.width, grid.height, kWhite);
  for (int row = grid.height - 1; row >= 0; --row) {
    for (int column = 0; column < grid.width; ++column) piece += gray_of(grid.at(column, row));
    if (piece.size() < kPiece) continue;
    take(piece);
    piece.clear();
  }
  take(piece);
}

std::string grid_to_yaml(const common::OccupancyGrid& grid, const std::string& image) {
  return fmt::format(
      "image: {}\nmode: trinary\nresolution: {}\norigin: [{}, {}, 0]\nnegate: 0\noccupied_thresh: {}\nfree_thresh: "
      "{}\n",
      image, grid.resolution, grid.origin.x(), grid.origin.y(), kOccupiedThreshold, kFreeThreshold);
}

common::Result<common::OccupancyGrid> grid_from_files(std::istream& pgm, const std::string& yaml) {
  common::OccupancyGrid grid;
  try {
    const YAML::Node node = YAML::Load(yaml);
    grid.resolution = node["resolution"].as<double>();
    grid.origin = {node["origin"][0].as<double>(), node["origin"][1].as<double>()};
  } catch (const std::exception& exception) {
    return refused(fmt::format("resolution and origin cannot be read: {}", exception.what()));
  }
  if (!std::isfinite(grid.resolution) || grid.resolution <= 0.0 || !grid.origin.allFinite()) {
    return refused("resolution must be above 0, the origin finite");
  }
  if (auto head = read_head(pgm, grid); !head) return tl::unexpected(head.error());
  if (auto rows = read_rows(pgm, grid); !rows) return tl::unexpected(rows.error());
  return grid;
}

}  // namespace slamfuse::service
