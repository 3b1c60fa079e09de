// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "common/error.hpp"
#include "laser_slam/laser_localization.hpp"

namespace slamfuse::service {

/// Reads a map to localise in from what a user may point at: a map bundle, a YAML file of Nav2's map server, or a
/// folder with exactly one such file. Errors (kInvalidInput, naming the file): none of these, or it cannot be read; a
/// bundle without a laser map.
common::Result<laser_slam::LocalizationMap> read_localization_map(const std::filesystem::path& path);

}  // namespace slamfuse::service
