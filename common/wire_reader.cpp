// SPDX-License-Identifier: BSD-3-Clause
#include "common/wire_reader.hpp"

#include <utility>

#include <fmt/format.h>

namespace slamfuse::common {
namespace {

constexpr std::size_t kEncapsulationBytes = 4;

bool is_big_endian_cdr(std::span<const std::uint8_t> message) {
  return message.size() >= 2 && message[0] == 0 && message[1] == 0;
}

std::span<const std::uint8_t> behind_encapsulation(std::span<const std::uint8_t> message) {
  return message.subspan(std::min(message.size(), kEncapsulationBytes));
}

std::string to_text(std::span<const std::uint8_t> bytes) { return {bytes.begin(), bytes.end()}; }

/// A stamp of seconds and nanoseconds; nothing when there is no such time.
bool to_stamp(std::int64_t seconds, std::uint32_t nanoseconds, Nanoseconds& stamp) {
  if (seconds < 0 || seconds >= kLatestStamp / kNanosecondsPerSecond || nanoseconds >= kNanosecondsPerSecond) {
    return false;
  }
  stamp = seconds * kNanosecondsPerSecond + nanoseconds;
  return true;
}

}  // namespace

std::string plain_frame(std::string frame) {
  if (frame.starts_with('/')) frame.erase(0, 1);
  return frame;
}

std::size_t WireReader::list_length(std::size_t item_bytes) {
  const auto count = number<std::uint32_t>();
  const std::size_t left = bytes_.size() - at_;
  if (count <= left / item_bytes) return count;
  fail(
      fmt::format("a list of {} items at byte {}, which do not fit into the {} bytes that are left", count, at_, left));
  return 0;
}

std::span<const std::uint8_t> WireReader::take(std::size_t count) {
  if (!problem_.empty()) return {};
  if (count > bytes_.size() - at_) {
    fail(fmt::format("ends after {} bytes, {} more are needed", bytes_.size(), count - (bytes_.size() - at_)));
    return {};
  }
  const auto taken = bytes_.subspan(at_, count);
  at_ += count;
  return taken;
}

void WireReader::fail(std::string problem) {
  if (problem_.empty()) problem_ = std::move(problem);
}

void WireReader::align(std::size_t size) {
  const std::size_t step = std::min(size, alignment_);
  take((step - at_ % step) % step);
}

CdrReader::CdrReader(std::span<const std::uint8_t> message)
    : WireReader(behind_encapsulation(message), is_big_endian_cdr(message), sizeof(double)) {
  if (message.size() < kEncapsulationBytes) {
    fail("shorter than the head of CDR data");
  } else if (message[0] != 0 || message[1] > 1) {
    fail(fmt::format("encapsulation 0x{:02x}{:02x} (known: 0x0000 and 0x0001, classic CDR)", message[0], message[1]));
  }
}

std::string CdrReader::text() {
  const auto bytes = take(list_length(1));
  if (!bytes.empty() && bytes.back() != 0) fail("a text that does not end with 0");
  return bytes.empty() ? std::string() : to_text(bytes.first(bytes.size() - 1));
}

RosHeader CdrReader::header() {
  RosHeader header;
  const auto seconds = number<std::int32_t>();
  const auto nanoseconds = number<std::uint32_t>();
  if (!to_stamp(seconds, nanoseconds, header.stamp)) fail(fmt::format("stamp {} s {} ns", seconds, nanoseconds));
  header.frame = plain_frame(text());
  return header;
}

std::string Ros1Reader::text() { return to_text(take(list_length(1))); }

RosHeader Ros1Reader::header() {
  RosHeader header;
  number<std::uint32_t>();  // counts the messages
  const auto seconds = number<std::uint32_t>();
  const auto nanoseconds = number<std::uint32_t>();
  if (!to_stamp(seconds, nanoseconds, header.stamp)) fail(fmt::format("stamp {} s {} ns", seconds, nanoseconds));
  header.frame = plain_frame(text());
  return header;
}

}  // namespace slamfuse::common
