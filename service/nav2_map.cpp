// SPDX-License-Identifier: BSD-3-Clause
#include "service/nav2_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "service/bounded_file.hpp"
#include "service/map_image.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxYamlBytes = std::uintmax_t{1} << 20;
constexpr int kWhite = 255;
constexpr double kOccupied = 100.0;

enum class Mode { kTrinary, kScale, kRaw };

struct Description {
  fs::path image;
  double resolution = 0.0;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  Mode mode = Mode::kTrinary;
  bool negate = false;
  double occupied_threshold = 0.0;
  double free_threshold = 0.0;
};

/// A key whose value will not do; caught in read_description().
class BadKey : public std::runtime_error {
 public:
  BadKey(const std::string& key, const std::string& found, const std::string& allowed)
      : std::runtime_error(fmt::format("'{}' is {}, allowed is {}", key, found, allowed)) {}
};

std::string text_of(const YAML::Node& node) {
  if (!node) return "missing";
  return YAML::Dump(YAML::Clone(node));
}

template <class T>
T value_of(const YAML::Node& map, const std::string& key, const std::string& allowed) {
  const YAML::Node node = map[key];
  T value{};
  if (!node || !YAML::convert<T>::decode(node, value)) throw BadKey(key, text_of(node), allowed);
  return value;
}

double number_of(const YAML::Node& map, const std::string& key, double low, double high, const std::string& allowed) {
  const auto value = value_of<double>(map, key, allowed);
  if (!(low <= value && value <= high)) throw BadKey(key, text_of(map[key]), allowed);
  return value;
}

Eigen::Vector2d origin_of(const YAML::Node& map) {
  const std::string allowed = "[x, y, 0] in metres: slamfuse does not take turned maps";
  const auto origin = value_of<std::vector<double>>(map, "origin", allowed);
  const bool good = origin.size() == 3 && std::isfinite(origin[0]) && std::isfinite(origin[1]) && origin[2] == 0.0;
  if (!good) throw BadKey("origin", text_of(map["origin"]), allowed);
  return {origin[0], origin[1]};
}

Mode mode_of(const YAML::Node& map) {
  if (!map["mode"]) return Mode::kTrinary;
  constexpr std::array<std::pair<const char*, Mode>, 3> kModes{
      {{"trinary", Mode::kTrinary}, {"scale", Mode::kScale}, {"raw", Mode::kRaw}}};
  const std::string allowed = "trinary, scale or raw";
  const auto name = value_of<std::string>(map, "mode", allowed);
  for (const auto& [known, mode] : kModes) {
    if (name == known) return mode;
  }
  throw BadKey("mode", name, allowed);
}

bool negate_of(const YAML::Node& map) {
  int number = 0;
  if (map["negate"] && YAML::convert<int>::decode(map["negate"], number)) return number != 0;
  return value_of<bool>(map, "negate", "0 or 1, false or true");
}

/// Throws BadKey.
Description description_of(const YAML::Node& map) {
  Description result;
  const auto image = value_of<std::string>(map, "image", "the name of a picture");
  if (image.empty()) throw BadKey("image", "empty", "the name of a picture");
  result.image = image;
  result.resolution = number_of(map, "resolution", 1e-4, 1e3, "0.0001 to 1000 m");
  result.origin = origin_of(map);
  result.mode = mode_of(map);
  result.negate = negate_of(map);
  result.occupied_threshold = number_of(map, "occupied_thresh", 0.0, 1.0, "0 to 1");
  result.free_threshold = number_of(map, "free_thresh", 0.0, 1.0, "0 to 1");
  if (result.free_threshold >= result.occupied_threshold) {
    throw BadKey("free_thresh", text_of(map["free_thresh"]),
                 fmt::format("less than occupied_thresh, which is {}", result.occupied_threshold));
  }
  return result;
}

/// The YAML file as a tree; throws what yaml-cpp throws.
common::Result<YAML::Node> load(const fs::path& path) {
  const auto text = read_bounded(path, kMaxYamlBytes);
  if (!text) return tl::unexpected(text.error());
  return YAML::Load(*text);
}

common::Result<Description> read_description(const fs::path& path) {
  try {
    const auto map = load(path);
    if (!map) return tl::unexpected(map.error());
    if (!map->IsMap()) return common::invalid_input(path.string() + ": not a map of Nav2: no keys");
    Description description = description_of(*map);
    if (description.image.is_relative()) description.image = path.parent_path() / description.image;
    return description;
  } catch (const std::exception& exception) {
    return common::invalid_input(fmt::format("{}: not a map of Nav2: {}", path.string(), exception.what()));
  }
}

/// The cell for a pixel whose samples are these.
std::int8_t cell_of(const std::uint8_t* samples, const MapImage& image, const Description& description) {
  const std::size_t colours = image.channels - (image.has_alpha() ? 1 : 0);
  const bool opaque = !image.has_alpha() || samples[colours] == kWhite;
  const std::size_t averaged = description.mode == Mode::kTrinary ? image.channels : colours;
  // Nav2 sees every picture in three colours, so gray weighs three times as much as opacity.
  const int weight = colours == 1 ? 3 : 1;
  int sum = 0;
  int weights = 0;
  for (std::size_t i = 0; i < averaged; ++i) {
    const int times = i < colours ? weight : 1;
    sum += times * samples[i];
    weights += times;
  }
  const double shade = static_cast<double>(sum) / (weights * kWhite);
  const double occupancy = description.negate ? shade : 1.0 - shade;
  if (description.mode == Mode::kRaw) {
    const double value = std::round(shade * kWhite);
    return value <= kOccupied ? static_cast<std::int8_t>(value) : common::OccupancyGrid::kUnknown;
  }
  if (description.mode == Mode::kScale && !opaque) return common::OccupancyGrid::kUnknown;
  if (occupancy > description.occupied_threshold) return static_cast<std::int8_t>(kOccupied);
  if (occupancy < description.free_threshold) return 0;
  if (description.mode == Mode::kTrinary) return common::OccupancyGrid::kUnknown;
  return static_cast<std::int8_t>(std::rint((occupancy - description.free_threshold) /
                                            (description.occupied_threshold - description.free_threshold) * kOccupied));
}

}  // namespace

bool is_nav2_map(const fs::path& yaml) {
  try {
    const auto map = load(yaml);
    return map && map->IsMap() && (*map)["image"] && (*map)["resolution"];
  } catch (const std::exception&) {
    return false;
  }
}

common::Result<common::OccupancyGrid> read_nav2_map(const fs::path& yaml) {
  const auto description = read_description(yaml);
  if (!description) return tl::unexpected(description.error());
  const auto image = read_map_image(description->image);
  if (!image) return common::invalid_input(fmt::format("{}: image: {}", yaml.string(), image.error().message));
  common::OccupancyGrid grid;
  grid.resolution = description->resolution;
  grid.origin = description->origin;
  grid.width = image->size.width;
  grid.height = image->size.height;
  const auto width = static_cast<std::size_t>(grid.width);
  grid.cells.reserve(width * static_cast<std::size_t>(grid.height));
  for (auto row = static_cast<std::size_t>(grid.height); row-- > 0;) {  // the image's top row is the farthest in y
    for (std::size_t column = 0; column < width; ++column) {
      grid.cells.push_back(
          cell_of(image->samples.data() + (row * width + column) * image->channels, *image, *description));
    }
  }
  return grid;
}

}  // namespace slamfuse::service
