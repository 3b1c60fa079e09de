// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string_view>
#include <utility>

#include "common/error.hpp"

namespace slamfuse::service {

/// A file that is there whole or not at all: written piece by piece to a temporary name beside it, then synced and
/// renamed. Gone with the object, if it was not published.
class DurableFile {
 public:
  /// Errors (kFailed) here and below name the file and the system's reason, e.g. a full disk.
  static common::Result<DurableFile> create(const std::filesystem::path& path);
  ~DurableFile();
  DurableFile(DurableFile&& other) noexcept;
  DurableFile& operator=(DurableFile&&) = delete;
  DurableFile(const DurableFile&) = delete;
  DurableFile& operator=(const DurableFile&) = delete;

  common::Result<void> append(std::string_view content);
  /// Nothing may be appended after it.
  common::Result<void> publish();

 private:
  DurableFile(std::filesystem::path path, int file) : path_(std::move(path)), file_(file) {}
  bool close();

  std::filesystem::path path_;
  int file_;  // descriptor; below 0 once closed
};

/// Writes a file so that it is there whole or not at all: to a temporary name beside it, synced, renamed. Errors
/// (kFailed) name the file and the system's reason, e.g. a full disk; nothing is left behind then.
common::Result<void> write_durably(const std::filesystem::path& path, std::string_view content);

/// Moves a file or folder to another name on the same file system, taking the place of what is there. What was there
/// survives until the new one stands. Errors (kFailed).
common::Result<void> replace_path(const std::filesystem::path& from, const std::filesystem::path& to);

/// Makes the names in a folder survive a power cut. Errors (kFailed).
common::Result<void> sync_folder(const std::filesystem::path& folder);

}  // namespace slamfuse::service
