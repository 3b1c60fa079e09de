// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/calibration.hpp"
#include "common/error.hpp"
#include "common/keyframe.hpp"
#include "common/landmark.hpp"
#include "common/occupancy_grid.hpp"
#include "common/trajectory.hpp"
#include "fusion/alignment.hpp"

namespace slamfuse::service {

/// The fused map of a run: DESIGN section 6, format in service/README.md. What is large is only looked at: it must
/// outlive the writing.
struct MapBundle {
  std::string program_version;
  std::uint64_t seed = 0;
  std::string recording;
  bool incomplete = false;                                   ///< the run was interrupted
  const common::OccupancyGrid* grid = nullptr;               ///< in the laser map's frame; null without laser
  std::string_view laser_state;                              ///< LaserSlam::serialize(); empty without laser
  std::vector<common::Landmark> landmarks;                   ///< in the visual map's frame
  std::vector<common::Keyframe> keyframes;                   ///< there, too
  std::map<std::string, common::CameraCalibration> cameras;  ///< that took them
  std::optional<fusion::Alignment> alignment;
  std::map<std::string, common::Trajectory2> trajectories;  ///< by name: "laser", "visual", "fused"
};

/// Writes the bundle as the folder `path`, taking the place of an older one: to a temporary name, synced, renamed. One
/// file after the other is made, the image in pieces: beside the bundle it takes the largest other file's size in
/// memory, not that of grid and laser state. Errors (kFailed): e.g. disk full; nothing is left behind then.
common::Result<void> write_map_bundle(const MapBundle& bundle, const std::filesystem::path& path);

/// What map.yaml says, without the maps themselves.
struct MapBundleFile {
  std::string name;
  std::uintmax_t bytes = 0;
  std::uint32_t crc32 = 0;
};
struct MapBundleSummary {
  std::string program_version;
  std::uint64_t seed = 0;
  std::string recording;
  bool incomplete = false;
  std::optional<fusion::Alignment> alignment;  ///< of the visual with the laser map, if it was accepted
  std::vector<MapBundleFile> files;
};

/// A bundle read back: the files and their content as written.
struct LoadedMapBundle {
  MapBundleSummary summary;
  std::optional<common::OccupancyGrid> grid;  ///< cells 0, 100 or unknown
  std::string laser_state;
  std::vector<common::Landmark> landmarks;
};

/// Whether the folder looks like a map bundle: it has a map.yaml.
bool is_map_bundle(const std::filesystem::path& path);

/// The names of the files in the bundle in this folder, map.yaml included; empty when it is not a readable bundle.
std::vector<std::string> files_of_map_bundle(const std::filesystem::path& path);

/// Reads a bundle and checks every file against its length and checksum. Beside what it gives it takes the size of the
/// landmarks' file in memory. Errors (kInvalidInput, naming the file): not a
/// bundle, a file missing, cut, altered, larger than kMaxMapFileBytes, or of a newer format.
common::Result<LoadedMapBundle> read_map_bundle(const std::filesystem::path& path);

/// Larger files in a bundle are refused: bounds the memory a broken or hostile bundle can take.
inline constexpr std::uintmax_t kMaxMapFileBytes = std::uintmax_t{1} << 31;

}  // namespace slamfuse::service
