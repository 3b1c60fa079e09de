// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace slamfuse::fuzz {

/// A folder of this process in memory, emptied when it ends.
const std::filesystem::path& scratch();

/// Writes a file there.
std::filesystem::path write_scratch(const std::string& name, const std::uint8_t* data, std::size_t size);

}  // namespace slamfuse::fuzz
