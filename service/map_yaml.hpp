// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/error.hpp"
#include "service/map_bundle.hpp"

namespace slamfuse::service {

/// The names of the files of a bundle.
inline constexpr const char* kMapYaml = "map.yaml";
inline constexpr const char* kGridImage = "grid.pgm";
inline constexpr const char* kGridYaml = "grid.yaml";
inline constexpr const char* kLaserState = "laser_state.bin";
inline constexpr const char* kLandmarks = "landmarks.bin";
inline constexpr const char* kLandmarksPly = "landmarks.ply";
inline constexpr const char* kColmapFolder = "colmap";
inline constexpr const char* kColmapCameras = "colmap/cameras.txt";
inline constexpr const char* kColmapImages = "colmap/images.txt";
inline constexpr const char* kColmapPoints = "colmap/points3D.txt";

/// Whether a file of this name is among them.
bool has_file(const std::vector<MapBundleFile>& files, const std::string& name);

/// The text with a last line `crc32: "..."` that covers everything before it.
std::string sealed(std::string yaml);

/// The text of map.yaml, sealed, for a bundle whose other files are `files`. Maps and links between them are lists, so
/// that a later version can hold several submaps of each kind.
std::string map_yaml_of(const MapBundle& bundle, const std::vector<MapBundleFile>& files);

/// Reads what read_map_bundle() needs of it. Errors (kInvalidInput): broken YAML, another format, a newer version, a
/// broken seal (the text was cut or altered), a missing or impossible value, a file name that leaves the folder, a file
/// too large.
common::Result<MapBundleSummary> parse_map_yaml(const std::string& text);

}  // namespace slamfuse::service
