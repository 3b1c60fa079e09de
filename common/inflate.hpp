// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/error.hpp"

namespace slamfuse::common {

/// Decompresses one piece of a file whose size is known. `compression` is "none" (or empty), "bz2", "lz4" (its frame
/// format) or "zstd". Memory grows with what comes out, so a false size takes none. Error (kInvalidInput), the reason
/// alone: an unknown compression, damaged data, not exactly `size` bytes in it.
Result<std::vector<std::uint8_t>> inflate(const std::string& compression, std::span<const std::uint8_t> stored,
                                          std::size_t size);

}  // namespace slamfuse::common
