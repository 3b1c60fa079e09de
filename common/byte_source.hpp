// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

#include "common/error.hpp"

namespace slamfuse::common {

/// The bytes of a file from front to back, decompressed on the way.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// Fills the front of `buffer` and returns how many bytes it wrote; 0 only at the end. Error (kInvalidInput): the
  /// file cannot be read, or its compressed data is damaged or ends early; what was returned before stays valid.
  virtual Result<std::size_t> read(std::span<char> buffer) = 0;
};

/// Opens a regular file: gzip or bzip2 when its first bytes say so, else as it is. Error (kInvalidInput): no such file,
/// not a regular file, not readable.
Result<std::unique_ptr<ByteSource>> open_byte_source(const std::filesystem::path& path);

}  // namespace slamfuse::common
