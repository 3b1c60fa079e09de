// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/byte_source.hpp"
#include "common/error.hpp"

namespace slamfuse::common {

/// A text file line by line, decompressed on the way, in bounded memory whatever the length of its lines.
class LineReader {
 public:
  /// Longer lines are cut to this many characters and marked; a scan of 4096 beams takes about 30 kB.
  static constexpr std::size_t kLongestLine = std::size_t{1} << 20;

  struct Line {
    std::string_view text;   ///< without its end ("\n" or "\r\n"); valid until the next call
    std::size_t number = 0;  ///< from 1
    bool too_long = false;   ///< the text is only the beginning
  };

  explicit LineReader(std::unique_ptr<ByteSource> source);

  /// The next line; empty at the end. Errors are those of ByteSource::read and come behind the last good line.
  Result<std::optional<Line>> next();

 private:
  std::unique_ptr<ByteSource> source_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;  ///< of the unread bytes in buffer_
  std::size_t end_ = 0;
  std::string line_;
  std::size_t number_ = 0;
};

/// A LineReader on a file; errors as open_byte_source.
Result<LineReader> open_lines(const std::filesystem::path& path);

}  // namespace slamfuse::common
