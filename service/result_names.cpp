// SPDX-License-Identifier: BSD-3-Clause
#include "service/result_names.hpp"

#include <algorithm>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "service/map_bundle.hpp"
#include "service/run_files.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;

const std::string kMapFolder = "map";

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

tl::unexpected<common::Error> in_the_way(const fs::path& path, const std::string& reason) {
  return common::invalid_input(
      fmt::format("{} is in the way: {}; choose another output folder or move it away", path.string(), reason));
}

bool begins_with(const fs::path& path, const std::string& beginning) {
  std::string start(beginning.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  return file && start == beginning;
}

/// Whether a folder inside a bundle holds files of the bundle.
bool holds_one_of(const std::string& folder, const std::vector<std::string>& names) {
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& name) { return name.starts_with(folder + "/"); });
}

common::Result<void> check_map(const fs::path& map) {
  std::error_code error;
  if (!fs::is_directory(fs::symlink_status(map, error))) return in_the_way(map, "it is not a folder");
  const auto known = files_of_map_bundle(map);
  for (const auto& entry :
       fs::recursive_directory_iterator(map, fs::directory_options::skip_permission_denied, error)) {
    const std::string name = entry.path().lexically_relative(map).generic_string();
    const bool ours =
        entry.is_directory(error) && !entry.is_symlink(error) ? holds_one_of(name, known) : contains(known, name);
    if (!ours) return in_the_way(entry.path(), "it is not part of a map bundle");
  }
  if (error) return in_the_way(map, error.message());
  return {};
}

common::Result<void> check_file(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(path, error))) return in_the_way(path, "it is not a file");
  if (path.extension() == ".tum" && !begins_with(path, kTrajectoryFileStart)) {
    return in_the_way(path, "slamfuse has not written it");
  }
  return {};
}

}  // namespace

const std::vector<std::string>& result_names(ResultKind kind) {
  static const std::vector<std::string> run{"odometry.tum",    "laser.tum",        "visual.tum",      "fused.tum",
                                            "laser_final.tum", "visual_final.tum", "fused_final.tum", "status.csv",
                                            kMapFolder,        "metrics.json",     "report.html"};
  static const std::vector<std::string> alignment{"metrics.json", "visual_aligned.tum", "trajectories.svg"};
  return kind == ResultKind::kRun ? run : alignment;
}

common::Result<void> check_replaceable(const fs::path& folder, ResultKind kind) {
  const auto is_there = [&](const std::string& name) {
    std::error_code error;
    return fs::exists(fs::symlink_status(folder / name, error));
  };
  const auto& names = result_names(kind);
  for (const auto& name : result_names(kind == ResultKind::kRun ? ResultKind::kAlignment : ResultKind::kRun)) {
    if (!contains(names, name) && is_there(name)) {
      return in_the_way(folder / name, fmt::format("the folder has results of `slamfuse {}`",
                                                   kind == ResultKind::kRun ? "align" : "run"));
    }
  }
  for (const auto& name : names) {
    if (!is_there(name)) continue;
    if (auto checked = name == kMapFolder ? check_map(folder / name) : check_file(folder / name); !checked) {
      return checked;
    }
  }
  return {};
}

}  // namespace slamfuse::service
