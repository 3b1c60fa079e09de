// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string_view>

#include "common/error.hpp"

namespace slamfuse::service {

/// Writes a file so that it is there whole or not at all: to a temporary name beside it, synced, renamed. Errors
/// (kFailed) name the file and the system's reason, e.g. a full disk; nothing is left behind then.
common::Result<void> write_durably(const std::filesystem::path& path, std::string_view content);

/// Moves a file or folder to another name on the same file system, taking the place of what is there. What was there
/// survives until the new one stands. Errors (kFailed).
common::Result<void> replace_path(const std::filesystem::path& from, const std::filesystem::path& to);

/// Makes the names in a folder survive a power cut. Errors (kFailed).
common::Result<void> sync_folder(const std::filesystem::path& folder);

}  // namespace slamfuse::service
