// SPDX-License-Identifier: BSD-3-Clause
#include "service/map_yaml.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <exception>
#include <sstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include "common/angle.hpp"
#include "service/checksum.hpp"

namespace slamfuse::service {
namespace {

constexpr const char* kFormat = "slamfuse map";
constexpr int kFormatVersion = 1;

constexpr double kSavedVariance = 0.02 * 0.02;  // [m^2] of a saved mapping's translation, whose own is not in the file

// What a mapping is taken to be off by where its map does not say.
constexpr double kUnknownError = 0.05;         // [m]
constexpr double kUnknownHeadingError = 0.02;  // [rad]

/// All digits, so that a reader gets the same number back.
std::string row_major(const Eigen::Matrix4d& matrix) {
  std::string text = "[";
  for (int i = 0; i < 16; ++i) text += fmt::format("{}{}", i == 0 ? "" : ", ", matrix(i / 4, i % 4));
  return text + "]";
}

std::string quoted(const std::string& text) {
  YAML::Emitter emitter;
  emitter << YAML::DoubleQuoted << text;
  return emitter.c_str();
}

void emit_maps(std::string& yaml, const MapBundle& bundle, const std::vector<MapBundleFile>& files) {
  if (has_file(files, kGridImage)) {
    yaml += fmt::format("laser_maps:\n  - id: 0\n    frame: laser_map\n    grid: {}\n", kGridYaml);
    if (has_file(files, kLaserState)) yaml += fmt::format("    state: {}\n", kLaserState);
  } else {
    yaml += "laser_maps: []\n";
  }
  if (has_file(files, kLandmarks)) {
    yaml += fmt::format("visual_maps:\n  - id: 0\n    frame: visual_map\n    landmarks: {}\n    points: {}\n",
                        kLandmarks, kLandmarksPly);
    const bool aligned = bundle.alignment && bundle.alignment->accepted;
    yaml += fmt::format("    points_frame: {}\n", aligned ? "laser_map" : "visual_map");
    if (has_file(files, kColmapImages)) yaml += fmt::format("    colmap: {}\n", kColmapFolder);
  } else {
    yaml += "visual_maps: []\n";
  }
}

/// G_LV and its factors (seed 004 eq. 7), 4x4 row by row, acting on (x, y, 0, 1) in the visual map's frame.
void emit_links(std::string& yaml, const MapBundle& bundle) {
  if (!bundle.alignment) {
    yaml += "links: []\n";
    return;
  }
  const fusion::Alignment& alignment = *bundle.alignment;
  const fusion::MappingMatrix& mapping = alignment.mapping;
  const std::array<std::pair<const char*, Eigen::Matrix4d>, 8> matrices{{{"T_traj_laser", mapping.T_traj_laser},
                                                                         {"R_laser", mapping.R_laser},
                                                                         {"T_curv_laser", mapping.T_curv_laser},
                                                                         {"T_ess", mapping.T_ess},
                                                                         {"T_curv_visual", mapping.T_curv_visual},
                                                                         {"R_visual", mapping.R_visual},
                                                                         {"T_traj_visual", mapping.T_traj_visual},
                                                                         {"G_LV", mapping.product()}}};
  yaml += fmt::format(
      "links:\n  - from: {{visual_map: 0}}\n    to: {{laser_map: 0}}\n    verdict: {}\n    reason: {}\n    method: {}\n"
      "    mean_scale: {}\n    heading_offset: {}\n",
      alignment.accepted ? "accepted" : "refused", quoted(alignment.reason), to_string(alignment.method),
      alignment.mean_scale, alignment.heading_offset);
  if (alignment.accepted) {
    yaml += fmt::format("    heldout_rmse: {}\n    forward_rmse: {}\n    heading_rmse: {}\n", alignment.heldout_rmse,
                        alignment.forward_rmse, alignment.heading_rmse);
  }
  for (const auto& [name, matrix] : matrices) yaml += fmt::format("    {}: {}\n", name, row_major(matrix));
}

tl::unexpected<common::Error> refused(const std::string& reason) {
  return common::invalid_input(fmt::format("{}: {}", kMapYaml, reason));
}

/// A plain name, or one in a folder of the bundle: nothing that leads out of it.
bool stays_inside(const std::string& name) {
  std::istringstream parts(name + '/');
  int depth = 0;
  for (std::string part; std::getline(parts, part, '/'); ++depth) {
    if (part.empty() || part == "." || part == ".." || part.find_first_of(std::string_view("\\\0", 2)) != part.npos) {
      return false;
    }
  }
  return depth >= 1 && depth <= 2;
}

std::uint32_t parse_crc(const std::string& text) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (error != std::errc{} || end != text.data() + text.size())
    throw YAML::Exception(YAML::Mark(), "bad crc32 " + text);
  return value;
}

double saved_error(const YAML::Node& link, const char* key) {
  const auto value = link[key].as<double>();
  if (!(value >= 0.0) || !std::isfinite(value)) {
    throw YAML::Exception(link[key].Mark(), fmt::format("{}: {} is no error in metres or radians", key, value));
  }
  return value;
}

/// What a link says of the alignment, which was accepted.
fusion::Alignment alignment_of(const YAML::Node& link) {
  const auto numbers = link["G_LV"].as<std::vector<double>>();
  if (numbers.size() != 16) throw YAML::Exception(link["G_LV"].Mark(), "G_LV: 16 numbers are needed");
  const Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  fusion::Alignment alignment;
  alignment.accepted = true;
  alignment.reason = "as saved with the map";
  alignment.map = {matrix.topLeftCorner<2, 2>(), matrix.topRightCorner<2, 1>()};
  alignment.heading_offset = link["heading_offset"].as<double>();
  if (!alignment.map.is_finite() || !std::isfinite(alignment.heading_offset) ||
      !(alignment.map.linear.determinant() > 0.0)) {
    throw YAML::Exception(link["G_LV"].Mark(), "G_LV: no mapping of one plane to another");
  }
  alignment.mapping = fusion::to_mapping_matrix(alignment.map);
  const fusion::AffineParts parts = fusion::take_apart(alignment.map);
  alignment.scale = parts.scale;
  alignment.scale_along_laser_axes = parts.scale_along_target_axes;
  alignment.mean_scale = parts.mean_scale;
  alignment.rotation_deg = common::to_degrees(parts.rotation);
  // Not known of a map from before these were saved.
  alignment.heldout_rmse = kUnknownError;
  alignment.heading_rmse = kUnknownHeadingError;
  if (link["heldout_rmse"]) {
    alignment.heldout_rmse = saved_error(link, "heldout_rmse");
    alignment.forward_rmse = saved_error(link, "forward_rmse");
    alignment.heading_rmse = saved_error(link, "heading_rmse");
  }
  if (link["method"].as<std::string>() == to_string(fusion::AlignmentMethod::kRigid)) {
    alignment.method = fusion::AlignmentMethod::kRigid;
  }
  alignment.covariance.bottomRightCorner<2, 2>() = kSavedVariance * Eigen::Matrix2d::Identity();
  return alignment;
}

MapBundleSummary summary_of(const YAML::Node& root) {
  MapBundleSummary summary;
  summary.program_version = root["slamfuse"].as<std::string>();
  summary.seed = root["seed"].as<std::uint64_t>();
  summary.recording = root["recording"].as<std::string>();
  summary.incomplete = root["incomplete"].as<bool>();
  for (const auto& link : root["links"]) {
    if (link["verdict"].as<std::string>() == "accepted") summary.alignment = alignment_of(link);
  }
  for (const auto& file : root["files"]) {
    summary.files.push_back({file["name"].as<std::string>(), file["bytes"].as<std::uintmax_t>(),
                             parse_crc(file["crc32"].as<std::string>())});
  }
  return summary;
}

/// Whether the last line is the checksum of everything before it.
bool is_sealed(const std::string& text) {
  const std::size_t last_line = text.rfind("crc32: ");
  return last_line != std::string::npos && sealed(text.substr(0, last_line)) == text;
}

}  // namespace

bool has_file(const std::vector<MapBundleFile>& files, const std::string& name) {
  return std::any_of(files.begin(), files.end(), [&](const auto& file) { return file.name == name; });
}

std::string sealed(std::string yaml) {
  const std::uint32_t crc32 = crc32_of(yaml);
  return std::move(yaml) + fmt::format("crc32: \"{:08x}\"\n", crc32);
}

std::string map_yaml_of(const MapBundle& bundle, const std::vector<MapBundleFile>& files) {
  std::string yaml = fmt::format(
      "format: {}\nversion: {}\nslamfuse: {}\nseed: {}\nrecording: {}\nincomplete: {}\n"
      "# Frames are z-up; poses are of base_link. Matrices are row by row and map visual_map to laser_map.\n",
      kFormat, kFormatVersion, quoted(bundle.program_version), bundle.seed, quoted(bundle.recording),
      bundle.incomplete);
  emit_maps(yaml, bundle, files);
  emit_links(yaml, bundle);
  yaml += "files:\n";
  for (const auto& file : files) {
    yaml += fmt::format("  - {{name: {}, bytes: {}, crc32: \"{:08x}\"}}\n", file.name, file.bytes, file.crc32);
  }
  return sealed(std::move(yaml));
}

common::Result<MapBundleSummary> parse_map_yaml(const std::string& text) {
  MapBundleSummary summary;
  try {
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap() || root["format"].as<std::string>() != kFormat) {
      return refused(fmt::format("'format' must be '{}'", kFormat));
    }
    const int version = root["version"].as<int>();
    if (version != kFormatVersion) {
      return refused(fmt::format("format version {}, this program reads {}", version, kFormatVersion));
    }
    if (!is_sealed(text)) return refused("the checksum in the last line does not match: the file was cut or altered");
    summary = summary_of(root);
  } catch (const std::exception& exception) {
    return refused(exception.what());
  }
  for (const auto& file : summary.files) {
    if (!stays_inside(file.name)) return refused(fmt::format("'{}' is not the name of a file of the map", file.name));
    if (file.bytes > kMaxMapFileBytes) {
      return refused(fmt::format("{} has {} bytes, at most {} are allowed", file.name, file.bytes, kMaxMapFileBytes));
    }
  }
  return summary;
}

}  // namespace slamfuse::service
