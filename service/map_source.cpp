// SPDX-License-Identifier: BSD-3-Clause
#include "service/map_source.hpp"

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "service/map_bundle.hpp"
#include "service/map_yaml.hpp"
#include "service/nav2_map.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;

common::Result<laser_slam::LocalizationMap> from_nav2(const fs::path& yaml) {
  auto grid = read_nav2_map(yaml);
  if (!grid) return tl::unexpected(grid.error());
  return laser_slam::LocalizationMap{yaml.string(), std::move(*grid), {}};
}

common::Result<laser_slam::LocalizationMap> from_bundle(const fs::path& path) {
  auto bundle = read_map_bundle(path);
  if (!bundle) return tl::unexpected(bundle.error());
  if (!bundle->grid) return common::invalid_input(path.string() + ": holds no laser map");
  return laser_slam::LocalizationMap{path.string(), std::move(*bundle->grid), std::move(bundle->laser_state)};
}

}  // namespace

common::Result<laser_slam::LocalizationMap> read_localization_map(const fs::path& path) {
  std::error_code error;
  if (fs::is_regular_file(path, error)) return from_nav2(path);
  if (!fs::is_directory(path, error)) return common::invalid_input(path.string() + ": no such map");
  std::vector<fs::path> yamls;
  for (const auto& entry : fs::directory_iterator(path, error)) {
    const bool yaml = entry.path().extension() == ".yaml" || entry.path().extension() == ".yml";
    if (yaml && is_nav2_map(entry.path())) yamls.push_back(entry.path());
  }
  // A bundle holds such a grid, too; Nav2's own map.yaml is not a bundle's.
  const bool nav2_named_map =
      std::any_of(yamls.begin(), yamls.end(), [](const fs::path& yaml) { return yaml.filename() == kMapYaml; });
  if (is_map_bundle(path) && !nav2_named_map) return from_bundle(path);
  if (yamls.size() == 1) return from_nav2(yamls.front());
  return common::invalid_input(fmt::format("{}: neither a map bundle nor a folder with one map of Nav2 (it has {})",
                                           path.string(), yamls.size()));
}

}  // namespace slamfuse::service
