// SPDX-License-Identifier: BSD-3-Clause
#include "common/line_reader.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace slamfuse::common {

LineReader::LineReader(std::unique_ptr<ByteSource> source) : source_(std::move(source)), buffer_(1U << 16) {}

Result<std::optional<LineReader::Line>> LineReader::next() {
  line_.clear();
  bool any = false;
  bool too_long = false;
  for (bool ended = false; !ended;) {
    if (begin_ == end_) {
      const Result<std::size_t> count = source_->read(buffer_);
      if (!count) return tl::unexpected(count.error());
      begin_ = 0;
      end_ = *count;
      if (end_ == 0) break;
    }
    any = true;
    const char* const start = buffer_.data() + begin_;
    const void* const newline = std::memchr(start, '\n', end_ - begin_);
    ended = newline != nullptr;
    const std::size_t length =
        ended ? static_cast<std::size_t>(static_cast<const char*>(newline) - start) : end_ - begin_;
    const std::size_t kept = std::min(length, kLongestLine - line_.size());
    too_long = too_long || kept < length;
    line_.append(start, kept);
    begin_ += length + (ended ? 1 : 0);
  }
  if (!any) return std::nullopt;
  if (!line_.empty() && line_.back() == '\r') line_.pop_back();
  return Line{line_, ++number_, too_long};
}

Result<LineReader> open_lines(const std::filesystem::path& path) {
  Result<std::unique_ptr<ByteSource>> source = open_byte_source(path);
  if (!source) return tl::unexpected(source.error());
  return LineReader(std::move(*source));
}

}  // namespace slamfuse::common
