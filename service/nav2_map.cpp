// SPDX-License-Identifier: BSD-3-Clause
#include "service/nav2_map.hpp"

#include <cmath>
#include <cstdint>
#include <exception>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "common/image_decoder.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxYamlBytes = std::uintmax_t{1} << 20;

struct Description {
  fs::path image;
  double resolution = 0.0;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  bool negate = false;
  double occupied_threshold = 0.65;
  double free_threshold = 0.25;
};

/// The YAML file as a tree; throws what yaml-cpp throws.
YAML::Node load(const fs::path& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw YAML::BadFile(path.string());
  if (size > kMaxYamlBytes) throw YAML::Exception(YAML::Mark::null_mark(), fmt::format("{} bytes are too many", size));
  return YAML::LoadFile(path.string());
}

/// Throws what yaml-cpp throws.
Description parse(const YAML::Node& node) {
  Description result;
  result.image = node["image"].as<std::string>();
  result.resolution = node["resolution"].as<double>();
  const auto origin = node["origin"].as<std::vector<double>>();
  if (origin.size() != 3) throw YAML::Exception(node["origin"].Mark(), "origin must be [x, y, yaw]");
  if (origin[2] != 0.0) throw YAML::Exception(node["origin"].Mark(), "a turned map: origin's third number must be 0");
  result.origin = {origin[0], origin[1]};
  if (const auto mode = node["mode"]; mode && mode.as<std::string>() == "raw") {
    throw YAML::Exception(mode.Mark(), "mode is raw, allowed are trinary and scale");
  }
  if (const auto negate = node["negate"]) result.negate = negate.as<int>() != 0;
  if (const auto threshold = node["occupied_thresh"]) result.occupied_threshold = threshold.as<double>();
  if (const auto threshold = node["free_thresh"]) result.free_threshold = threshold.as<double>();
  if (!(std::isfinite(result.resolution) && result.resolution > 0.0)) {
    throw YAML::Exception(node["resolution"].Mark(), "resolution must be above 0");
  }
  if (!result.origin.allFinite()) throw YAML::Exception(node["origin"].Mark(), "origin must be finite");
  if (!(0.0 <= result.free_threshold && result.free_threshold < result.occupied_threshold &&
        result.occupied_threshold <= 1.0)) {
    throw YAML::Exception(node.Mark(), "0 <= free_thresh < occupied_thresh <= 1 must hold");
  }
  return result;
}

common::Result<Description> read_description(const fs::path& path) {
  try {
    Description description = parse(load(path));
    if (description.image.is_relative()) description.image = path.parent_path() / description.image;
    return description;
  } catch (const std::exception& exception) {
    return common::invalid_input(fmt::format("{}: not a map of Nav2: {}", path.string(), exception.what()));
  }
}

std::int8_t cell_of(std::uint8_t gray, const Description& description) {
  const double occupancy = (description.negate ? gray : 255 - gray) / 255.0;
  if (occupancy > description.occupied_threshold) return 100;
  if (occupancy < description.free_threshold) return 0;
  return common::OccupancyGrid::kUnknown;
}

}  // namespace

bool is_nav2_map(const fs::path& yaml) {
  try {
    const YAML::Node node = load(yaml);
    return node.IsMap() && node["image"] && node["resolution"];
  } catch (const std::exception&) {
    return false;
  }
}

common::Result<common::OccupancyGrid> read_nav2_map(const fs::path& yaml) {
  const auto description = read_description(yaml);
  if (!description) return tl::unexpected(description.error());
  const auto image = common::read_gray_image(description->image, std::nullopt);
  if (!image) return tl::unexpected(image.error());
  common::OccupancyGrid grid;
  grid.resolution = description->resolution;
  grid.origin = description->origin;
  grid.width = image->size.width;
  grid.height = image->size.height;
  const auto width = static_cast<std::size_t>(grid.width);
  grid.cells.reserve(image->pixels->size());
  for (auto row = static_cast<std::size_t>(grid.height); row-- > 0;) {  // the image's top row is the farthest in y
    for (std::size_t column = 0; column < width; ++column) {
      grid.cells.push_back(cell_of((*image->pixels)[row * width + column], *description));
    }
  }
  return grid;
}

}  // namespace slamfuse::service
