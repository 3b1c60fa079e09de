// SPDX-License-Identifier: BSD-3-Clause
#include "service/grid_file.hpp"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <exception>
#include <optional>

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
/// Refuses sizes that can only be an accident (3.3 km at 5 cm).
constexpr int kMaxSide = 65535;

char gray_of(std::int8_t cell) {
  if (cell < 0) return kUnknownGray;
  if (cell >= kOccupiedPercent) return kOccupiedGray;
  if (cell <= kFreePercent) return kFreeGray;
  return kUnknownGray;
}

std::int8_t cell_of(char gray) {
  const double occupancy = (255.0 - static_cast<unsigned char>(gray)) / 255.0;
  if (occupancy > kOccupiedThreshold) return 100;
  if (occupancy < kFreeThreshold) return 0;
  return common::OccupancyGrid::kUnknown;
}

tl::unexpected<common::Error> refused(const std::string& reason) { return common::invalid_input("grid: " + reason); }

/// The next whole number of a PGM header; nothing if there is none in range.
std::optional<int> take_number(std::string_view& text) {
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start == std::string_view::npos) return std::nullopt;
  text.remove_prefix(start);
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || value < 0) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

}  // namespace

std::string grid_to_pgm(const common::OccupancyGrid& grid) {
  std::string pgm = fmt::format("P5\n{} {}\n255\n", grid.width, grid.height);
  pgm.reserve(pgm.size() + grid.cells.size());
  for (int row = grid.height - 1; row >= 0; --row) {
    for (int column = 0; column < grid.width; ++column) pgm += gray_of(grid.at(column, row));
  }
  return pgm;
}

std::string grid_to_yaml(const common::OccupancyGrid& grid, const std::string& image) {
  return fmt::format(
      "image: {}\nmode: trinary\nresolution: {}\norigin: [{}, {}, 0]\nnegate: 0\noccupied_thresh: {}\nfree_thresh: "
      "{}\n",
      image, grid.resolution, grid.origin.x(), grid.origin.y(), kOccupiedThreshold, kFreeThreshold);
}

common::Result<common::OccupancyGrid> grid_from_files(std::string_view pgm, const std::string& yaml) {
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

  if (!pgm.starts_with("P5")) return refused("the image is not a binary PGM");
  std::string_view rest = pgm.substr(2);
  const auto width = take_number(rest);
  const auto height = take_number(rest);
  const auto depth = take_number(rest);
  if (!width || !height || *width > kMaxSide || *height > kMaxSide || depth != 255 || rest.empty()) {
    return refused(fmt::format("the PGM header must give two sides up to {} and 255 grays", kMaxSide));
  }
  rest.remove_prefix(1);
  grid.width = *width;
  grid.height = *height;
  const std::size_t cells = static_cast<std::size_t>(*width) * static_cast<std::size_t>(*height);
  if (rest.size() != cells) {
    return refused(fmt::format("{}x{} pixels need {} bytes, there are {}", *width, *height, cells, rest.size()));
  }
  grid.cells.reserve(cells);
  for (int row = *height - 1; row >= 0; --row) {
    for (int column = 0; column < *width; ++column) {
      grid.cells.push_back(cell_of(
          rest[static_cast<std::size_t>(row) * static_cast<std::size_t>(*width) + static_cast<std::size_t>(column)]));
    }
  }
  return grid;
}

}  // namespace slamfuse::service
