// SPDX-License-Identifier: BSD-3-Clause
#include "common/look_ahead.hpp"

#include <algorithm>
#include <span>

namespace slamfuse::common {
namespace {
constexpr std::size_t kChunk = std::size_t{1} << 16;
}

std::size_t LookAhead::available(std::size_t enough) {
  while (!ended_ && bytes_.size() - next_ < enough) {
    const std::size_t size = bytes_.size();
    bytes_.resize(size + kChunk);
    const Result<std::size_t> count = source_->read(std::span(bytes_).subspan(size));
    bytes_.resize(size + count.value_or(0));
    ended_ = count.value_or(0) == 0;
    if (!count) failure_ = count.error();
  }
  return std::min(enough, bytes_.size() - next_);
}

std::size_t LookAhead::take(char* buffer, std::size_t length) {
  const std::size_t count = available(length);
  std::copy_n(bytes_.data() + next_, count, buffer);
  next_ += count;
  return count;
}

void LookAhead::set_mark() {
  mark_ = next_;
  // Moved down only when it is worth it.
  if (mark_ < kChunk || mark_ < bytes_.size() / 2) return;
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(mark_));
  next_ = mark_ = 0;
}

}  // namespace slamfuse::common
