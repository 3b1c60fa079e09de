// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "common/byte_source.hpp"

namespace slamfuse::common {

/// A byte source that tells how much is still to come before it is read, and can be read again from a mark on. What
/// lies between the mark and the farthest byte asked for is in memory.
class LookAhead {
 public:
  explicit LookAhead(std::unique_ptr<ByteSource> source) : source_(std::move(source)) {}

  /// How many bytes are still to come, at most `enough`.
  std::size_t available(std::size_t enough);
  /// Copies the next bytes and returns how many: fewer than `length` only where the source ends, or fails.
  std::size_t take(char* buffer, std::size_t length);
  /// Why there is nothing behind the last byte; empty where the source just ends, or was not read so far.
  const std::optional<Error>& failure() const { return failure_; }

  /// Here reading can go on again. What was before goes.
  void set_mark();
  void return_to_mark() { next_ = mark_; }

 private:
  std::unique_ptr<ByteSource> source_;
  std::vector<char> bytes_;
  std::size_t mark_ = 0;
  std::size_t next_ = 0;
  bool ended_ = false;
  std::optional<Error> failure_;
};

}  // namespace slamfuse::common
