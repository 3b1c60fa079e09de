// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "common/error.hpp"

namespace slamfuse::service {

/// Opens a file of at most `limit` bytes and gives their number. Errors (kInvalidInput, naming the file): not there,
/// not a file, larger.
common::Result<std::uintmax_t> open_bounded(const std::filesystem::path& path, std::uintmax_t limit,
                                            std::ifstream& file);

/// The content of such a file.
common::Result<std::string> read_bounded(const std::filesystem::path& path, std::uintmax_t limit);

}  // namespace slamfuse::service
