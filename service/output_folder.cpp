// SPDX-License-Identifier: BSD-3-Clause
#include "service/output_folder.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "service/durable_file.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;

tl::unexpected<common::Error> not_writable(const fs::path& path, const std::error_code& error) {
  return common::invalid_input(
      fmt::format("output folder {} cannot be written to: {}", path.string(), error.message()));
}

fs::path outermost_missing(fs::path path) {
  std::error_code error;
  fs::path missing;
  while (!path.empty() && !fs::exists(path, error)) {
    missing = path;
    if (path == path.parent_path()) break;
    path = path.parent_path();
  }
  return missing;
}

/// Where results are gathered; the number of the process makes it its own.
constexpr std::string_view kStagingName = ".slamfuse-";

/// What processes left behind that were killed.
void remove_abandoned(const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(kStagingName)) continue;
    const std::string number = name.substr(kStagingName.size());
    pid_t process = 0;
    const auto [end, problem] = std::from_chars(number.data(), number.data() + number.size(), process);
    if (problem != std::errc() || end != number.data() + number.size() || process <= 0) continue;
    const bool runs = process != ::getpid() && (::kill(process, 0) == 0 || errno != ESRCH);
    std::error_code ignored;
    if (!runs) fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace

common::Result<std::unique_ptr<OutputFolder>> OutputFolder::create(const fs::path& path, ResultKind kind) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error).lexically_normal();
  if (error) return not_writable(path, error);
  if (auto checked = check_replaceable(absolute, kind); !checked) return tl::unexpected(checked.error());
  const fs::path first_created = outermost_missing(absolute);
  fs::create_directories(absolute, error);
  if (error) return not_writable(path, error);
  std::unique_ptr<OutputFolder> folder(new OutputFolder(absolute, first_created, kind));
  remove_abandoned(absolute);
  fs::create_directory(folder->staging_, error);
  if (error) return not_writable(path, error);
  return folder;
}

OutputFolder::OutputFolder(fs::path path, fs::path first_created, ResultKind kind)
    : path_(std::move(path)),
      first_created_(std::move(first_created)),
      kind_(kind),
      staging_(path_ / fmt::format("{}{}", kStagingName, ::getpid())) {}

OutputFolder::~OutputFolder() {
  std::error_code error;
  fs::remove_all(staging_, error);
  if (first_created_.empty()) return;
  for (fs::path created = path_; fs::remove(created, error) && created != first_created_;) {
    created = created.parent_path();
  }
}

common::Result<void> OutputFolder::write(const std::string& name, std::string_view content) {
  return write_durably(staging_ / name, content);
}

common::Result<void> OutputFolder::publish() {
  std::error_code error;
  std::vector<std::string> made;
  for (const auto& entry : fs::directory_iterator(staging_, error)) made.push_back(entry.path().filename().string());
  if (error) return common::failed(fmt::format("cannot read {}: {}", staging_.string(), error.message()));
  std::sort(made.begin(), made.end());

  for (const std::string& name : result_names(kind_)) {
    if (std::find(made.begin(), made.end(), name) == made.end()) fs::remove_all(path_ / name, error);
  }
  for (const auto& name : made) {
    if (auto moved = replace_path(staging_ / name, path_ / name); !moved) return moved;
  }
  return sync_folder(path_);
}

}  // namespace slamfuse::service
