// SPDX-License-Identifier: BSD-3-Clause
#include "common/pnm_decoder.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <string_view>

#include "common/text_fields.hpp"

namespace slamfuse::common {
namespace {

struct Head {
  std::size_t channels = 1;
  ImageSize size;
  unsigned maximum = 255;     ///< the value of white
  std::size_t pixels_at = 0;  ///< where the pixels begin
};

bool is_blank(std::uint8_t c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// The head is "P5 width height maximum" with blanks and "# comment" lines between, then one blank.
std::optional<Head> read_head(std::span<const std::uint8_t> bytes) {
  std::size_t at = 2;
  const auto next_number = [&]() -> std::optional<int> {
    while (at < bytes.size() && (is_blank(bytes[at]) || bytes[at] == '#')) {
      if (bytes[at++] != '#') continue;
      while (at < bytes.size() && bytes[at] != '\n') ++at;
    }
    const std::size_t begin = at;
    while (at < bytes.size() && bytes[at] >= '0' && bytes[at] <= '9') ++at;
    const auto value = parse_integer({reinterpret_cast<const char*>(bytes.data()) + begin, at - begin});
    if (!value || *value < 1 || *value > std::numeric_limits<int>::max()) return std::nullopt;
    return static_cast<int>(*value);
  };
  Head head;
  const std::optional<int> width = next_number();
  const std::optional<int> height = next_number();
  const std::optional<int> maximum = next_number();
  constexpr int kHighestMaximum = 65'535;
  if (!width || !height || !maximum || *maximum > kHighestMaximum) return std::nullopt;
  if (at >= bytes.size() || !is_blank(bytes[at])) return std::nullopt;
  head.channels = bytes[1] == '6' ? 3 : 1;
  head.size = {*width, *height};
  head.maximum = static_cast<unsigned>(*maximum);
  head.pixels_at = at + 1;
  return head;
}

}  // namespace

bool is_pnm(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 2 && bytes[0] == 'P' && (bytes[1] == '5' || bytes[1] == '6');
}

Result<ImageSize> pnm_size(std::span<const std::uint8_t> bytes) {
  const std::optional<Head> head = read_head(bytes);
  if (!head) return invalid_input("cut or garbled PGM or PPM: no width, height and maximum value");
  return head->size;
}

Result<std::vector<std::uint8_t>> decode_pnm(std::span<const std::uint8_t> bytes, ImageSize size) {
  const std::optional<Head> head = read_head(bytes);
  const std::size_t count = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  constexpr unsigned kHighestByte = 255;
  const std::size_t sample_bytes = head && head->maximum > kHighestByte ? 2 : 1;
  if (!head || head->size != size || bytes.size() - head->pixels_at < count * head->channels * sample_bytes) {
    return invalid_input("cut or garbled PGM or PPM: fewer pixels than its head states");
  }
  std::size_t at = head->pixels_at;
  const auto next_sample = [&] {
    unsigned value = bytes[at++];
    if (sample_bytes == 2) value = value << 8 | bytes[at++];
    return std::min(value, head->maximum) * kHighestByte / head->maximum;
  };
  std::vector<std::uint8_t> pixels(count);
  for (std::uint8_t& pixel : pixels) {
    unsigned value = next_sample();
    if (head->channels == 3) {
      const unsigned green = next_sample();
      const unsigned blue = next_sample();
      value = (299 * value + 587 * green + 114 * blue + 500) / 1000;
    }
    pixel = static_cast<std::uint8_t>(value);
  }
  return pixels;
}

}  // namespace slamfuse::common
