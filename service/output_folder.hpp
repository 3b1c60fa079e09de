// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "common/error.hpp"
#include "service/result_names.hpp"

namespace slamfuse::service {

/// Where a command writes its results: all of them or none.
///
/// Files are gathered in a hidden folder inside the output folder and moved to their names at the end, so that a full
/// disk, an error or a crash never leaves half a result, nor a mixture with older results.
class OutputFolder {
 public:
  /// Creates the folder (and its parents) if it is not there and makes sure that it can be written to and that only
  /// older results of this kind will be lost, see check_replaceable(). Errors (kInvalidInput): it is not so.
  static common::Result<std::unique_ptr<OutputFolder>> create(const std::filesystem::path& path, ResultKind kind);
  /// What was not published vanishes, and so do folders that create() made and that are still empty.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// The hidden folder: what is put here is published.
  const std::filesystem::path& staging() const { return staging_; }

  /// A file of this name with this content. Errors (kFailed): e.g. disk full.
  common::Result<void> write(const std::string& name, std::string_view content);

  /// Moves everything gathered into place, instead of what an earlier run left: its files that this run has not made
  /// are removed; files of other names are left alone. Errors (kFailed).
  common::Result<void> publish();

 private:
  OutputFolder(std::filesystem::path path, std::filesystem::path first_created, ResultKind kind);

  std::filesystem::path path_;
  std::filesystem::path first_created_;  // the outermost folder that create() made, empty if none
  ResultKind kind_;
  std::filesystem::path staging_;
};

}  // namespace slamfuse::service
