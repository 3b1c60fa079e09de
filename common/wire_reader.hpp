// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>

#include "common/time.hpp"

namespace slamfuse::common {

/// Reads numbers out of a serialised message, never past its end. The first thing that does not fit sets a problem that
/// stays; from then on every number is 0 and every list empty, so a decoder may read on and ask once at the end. A list
/// is measured against the bytes that are left before anybody takes memory for it.
class WireReader {
 public:
  /// Numbers lie at multiples of their size, at most of `alignment`, counted from the beginning of `bytes`.
  WireReader(std::span<const std::uint8_t> bytes, bool big_endian, std::size_t alignment)
      : bytes_(bytes), big_endian_(big_endian), alignment_(alignment) {}

  /// Why the message cannot be read; empty while it can.
  const std::string& problem() const { return problem_; }

  template <class Number>
  requires std::is_arithmetic_v<Number> Number number() {
    align(sizeof(Number));
    const auto from = take(sizeof(Number));
    if (from.empty()) return Number{};
    std::uint8_t raw[sizeof(Number)];
    std::copy(from.begin(), from.end(), raw);
    if (big_endian_ != (std::endian::native == std::endian::big)) std::reverse(std::begin(raw), std::end(raw));
    Number value;
    std::memcpy(&value, raw, sizeof(Number));
    return value;
  }

  /// The length in front of a list whose items take `item_bytes` at least. It fits into the bytes that are left.
  std::size_t list_length(std::size_t item_bytes);
  /// The next `count` bytes; empty when there are not that many.
  std::span<const std::uint8_t> take(std::size_t count);

 protected:
  void fail(std::string problem);

 private:
  void align(std::size_t size);

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool big_endian_;
  std::size_t alignment_;
  std::string problem_;
};

/// A frame's name without the leading '/' that ROS 1 allowed: tf2 takes both for one.
std::string plain_frame(std::string frame);

/// The head of most ROS messages.
struct RosHeader {
  Nanoseconds stamp = 0;  ///< 0 to kLatestStamp, else the reader has a problem
  std::string frame;      ///< by plain_frame()
};

/// Common Data Representation as ROS 2 writes it: classic CDR (XCDR1) of either byte order behind the four bytes of the
/// encapsulation header (DDS-XTypes 1.3, 7.4.3 and 7.6.2); strings end with a 0 byte that their length counts.
class CdrReader : public WireReader {
 public:
  explicit CdrReader(std::span<const std::uint8_t> message);
  std::string text();
  RosHeader header();
};

/// Serialisation of ROS 1: little-endian, nothing aligned, strings as their length says; a header begins with a count.
class Ros1Reader : public WireReader {
 public:
  explicit Ros1Reader(std::span<const std::uint8_t> message) : WireReader(message, false, 1) {}
  std::string text();
  RosHeader header();
};

}  // namespace slamfuse::common
