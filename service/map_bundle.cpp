// SPDX-License-Identifier: BSD-3-Clause
#include "service/map_bundle.hpp"

#include <fstream>
#include <iterator>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "common/tum.hpp"
#include "service/checksum.hpp"
#include "service/durable_file.hpp"
#include "service/grid_file.hpp"
#include "service/landmark_file.hpp"
#include "service/landmark_ply.hpp"
#include "service/map_yaml.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;

/// map.yaml holds a few kilobytes; more is not ours.
constexpr std::uintmax_t kMaxMapYamlBytes = std::uintmax_t{1} << 20;

using Contents = std::vector<std::pair<std::string, std::string>>;  // name and bytes

Contents contents_of(const MapBundle& bundle) {
  Contents contents;
  if (bundle.grid && bundle.grid->width > 0) {
    contents.emplace_back(kGridImage, grid_to_pgm(*bundle.grid));
    contents.emplace_back(kGridYaml, grid_to_yaml(*bundle.grid, kGridImage));
  }
  if (!bundle.laser_state.empty()) contents.emplace_back(kLaserState, bundle.laser_state);
  if (!bundle.landmarks.empty()) {
    contents.emplace_back(kLandmarks, landmarks_to_bytes(bundle.landmarks));
    contents.emplace_back(kLandmarksPly,
                          landmarks_to_ply(bundle.landmarks, bundle.alignment.value_or(fusion::Alignment{})));
  }
  for (const auto& [name, trajectory] : bundle.trajectories) {
    contents.emplace_back(name + ".tum", common::to_tum(trajectory));
  }
  return contents;
}

common::Result<void> write_contents(const MapBundle& bundle, const fs::path& folder) {
  std::vector<MapBundleFile> files;
  for (const auto& [name, bytes] : contents_of(bundle)) {
    files.push_back({name, bytes.size(), crc32_of(bytes)});
    if (auto written = write_durably(folder / name, bytes); !written) return written;
  }
  if (auto written = write_durably(folder / kMapYaml, map_yaml_of(bundle, files)); !written) return written;
  return sync_folder(folder);
}

/// The content of a file of at most `limit` bytes.
common::Result<std::string> read_bounded(const fs::path& path, std::uintmax_t limit) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return common::invalid_input(path.string() + ": missing or not a file");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || size > limit) {
    return common::invalid_input(fmt::format("{}: {} bytes, at most {} are allowed", path.string(), size, limit));
  }
  std::ifstream file(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(file), {});
  if (!file) return common::invalid_input(path.string() + ": cannot be read");
  return bytes;
}

common::Result<std::string> read_checked(const fs::path& folder, const MapBundleFile& file) {
  const fs::path path = folder / file.name;
  auto bytes = read_bounded(path, kMaxMapFileBytes);
  if (!bytes) return bytes;
  if (bytes->size() != file.bytes) {
    return common::invalid_input(
        fmt::format("{}: {} bytes, map.yaml says {}: cut or replaced", path.string(), bytes->size(), file.bytes));
  }
  const std::uint32_t crc32 = crc32_of(*bytes);
  if (crc32 != file.crc32) {
    return common::invalid_input(fmt::format("{}: checksum {:08x}, map.yaml says {:08x}: the file was altered",
                                             path.string(), crc32, file.crc32));
  }
  return bytes;
}

common::Result<void> interpret(const std::map<std::string, std::string>& contents, LoadedMapBundle& bundle) {
  if (contents.contains(kGridImage) && contents.contains(kGridYaml)) {
    auto grid = grid_from_files(contents.at(kGridImage), contents.at(kGridYaml));
    if (!grid) return tl::unexpected(grid.error());
    bundle.grid = std::move(*grid);
  }
  if (contents.contains(kLandmarks)) {
    auto landmarks = landmarks_from_bytes(contents.at(kLandmarks));
    if (!landmarks) return tl::unexpected(landmarks.error());
    bundle.landmarks = std::move(*landmarks);
  }
  if (contents.contains(kLaserState)) bundle.laser_state = contents.at(kLaserState);
  return {};
}

}  // namespace

common::Result<void> write_map_bundle(const MapBundle& bundle, const fs::path& path) {
  const fs::path temporary = path.string() + ".partial";
  std::error_code error;
  fs::remove_all(temporary, error);
  if (!fs::create_directories(temporary, error)) {
    return common::failed(fmt::format("cannot write {}: {}", path.string(), error.message()));
  }
  auto done = write_contents(bundle, temporary);
  if (done) done = replace_path(temporary, path);
  if (!done) fs::remove_all(temporary, error);
  return done;
}

bool is_map_bundle(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path / kMapYaml, error);
}

std::vector<std::string> files_of_map_bundle(const fs::path& path) {
  const auto yaml = read_bounded(path / kMapYaml, kMaxMapYamlBytes);
  const auto summary = yaml ? parse_map_yaml(*yaml) : tl::unexpected(yaml.error());
  if (!summary) return {};
  std::vector<std::string> names{kMapYaml};
  for (const auto& file : summary->files) names.push_back(file.name);
  return names;
}

common::Result<LoadedMapBundle> read_map_bundle(const fs::path& path) {
  const auto yaml = read_bounded(path / kMapYaml, kMaxMapYamlBytes);
  if (!yaml) return tl::unexpected(yaml.error());
  auto summary = parse_map_yaml(*yaml);
  if (!summary) return common::invalid_input(path.string() + "/" + summary.error().message);

  LoadedMapBundle bundle;
  bundle.summary = std::move(*summary);
  std::map<std::string, std::string> contents;
  for (const auto& file : bundle.summary.files) {
    auto bytes = read_checked(path, file);
    if (!bytes) return tl::unexpected(bytes.error());
    contents[file.name] = std::move(*bytes);
  }
  if (auto done = interpret(contents, bundle); !done) {
    return common::invalid_input(path.string() + ": " + done.error().message);
  }
  return bundle;
}

}  // namespace slamfuse::service
