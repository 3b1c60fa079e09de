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
  bool plain = false;  ///< samples are decimal text
  std::size_t channels = 1;
  ImageSize size;
  unsigned maximum = 255;     ///< the value of white
  std::size_t pixels_at = 0;  ///< where the pixels begin
};

bool is_blank(std::uint8_t c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// Takes decimal numbers off data in which blanks and "# comment" lines stand between them.
class NumberScanner {
 public:
  NumberScanner(std::span<const std::uint8_t> bytes, std::size_t at) : bytes_(bytes), at_(at) {}

  std::size_t at() const { return at_; }
  /// The next number, nothing where there is none or it does not fit an int.
  std::optional<int> next() {
    while (at_ < bytes_.size() && (is_blank(bytes_[at_]) || bytes_[at_] == '#')) {
      if (bytes_[at_++] != '#') continue;
      while (at_ < bytes_.size() && bytes_[at_] != '\n') ++at_;
    }
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && bytes_[at_] >= '0' && bytes_[at_] <= '9') ++at_;
    const auto value = parse_integer({reinterpret_cast<const char*>(bytes_.data()) + begin, at_ - begin});
    if (!value || *value > std::numeric_limits<int>::max()) return std::nullopt;
    return static_cast<int>(*value);
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_;
};

/// The head is "P5 width height maximum", then one blank.
std::optional<Head> read_head(std::span<const std::uint8_t> bytes) {
  NumberScanner numbers(bytes, 2);
  const int width = numbers.next().value_or(0);
  const int height = numbers.next().value_or(0);
  const int maximum = numbers.next().value_or(0);
  constexpr int kHighestMaximum = 65'535;
  if (width < 1 || height < 1 || maximum < 1 || maximum > kHighestMaximum) return std::nullopt;
  if (numbers.at() >= bytes.size() || !is_blank(bytes[numbers.at()])) return std::nullopt;
  Head head;
  head.plain = bytes[1] == '2' || bytes[1] == '3';
  head.channels = bytes[1] == '3' || bytes[1] == '6' ? 3 : 1;
  head.size = {width, height};
  head.maximum = static_cast<unsigned>(maximum);
  head.pixels_at = numbers.at() + 1;
  return head;
}

constexpr unsigned kHighestByte = 255;

/// Puts the pixels together from samples 0..maximum. Whether there were enough of them.
template <class NextSample>
bool read_pixels(const Head& head, const NextSample& next_sample, std::vector<std::uint8_t>& pixels) {
  bool enough = true;
  const auto next = [&] {
    const std::optional<unsigned> value = next_sample();
    enough = enough && value;
    return std::min(value.value_or(0), head.maximum) * kHighestByte / head.maximum;
  };
  for (std::uint8_t& pixel : pixels) {
    unsigned value = next();
    if (head.channels == 3) {
      const unsigned green = next();
      const unsigned blue = next();
      value = (299 * value + 587 * green + 114 * blue + 500) / 1000;
    }
    pixel = static_cast<std::uint8_t>(value);
  }
  return enough;
}

}  // namespace

bool is_pnm(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 2 && bytes[0] == 'P' &&
         (bytes[1] == '2' || bytes[1] == '3' || bytes[1] == '5' || bytes[1] == '6');
}

Result<ImageSize> pnm_size(std::span<const std::uint8_t> bytes) {
  const std::optional<Head> head = read_head(bytes);
  if (!head) return invalid_input("cut or garbled PGM or PPM: no width, height and maximum value");
  return head->size;
}

Result<std::vector<std::uint8_t>> decode_pnm(std::span<const std::uint8_t> bytes, ImageSize size) {
  const auto cut = [] { return invalid_input("cut or garbled PGM or PPM: fewer pixels than its head states"); };
  const std::optional<Head> head = read_head(bytes);
  if (!head || head->size != size) return cut();
  const std::size_t count = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  const std::size_t samples = count * head->channels;
  const std::size_t sample_bytes = head->maximum > kHighestByte ? 2 : 1;
  const std::size_t needed = head->plain ? 2 * samples - 1 : samples * sample_bytes;  // plain: a digit, a blank
  if (bytes.size() - head->pixels_at < needed) return cut();

  std::vector<std::uint8_t> pixels(count);
  bool enough = false;
  if (head->plain) {
    NumberScanner numbers(bytes, head->pixels_at);
    enough = read_pixels(
        *head, [&]() -> std::optional<unsigned> { return numbers.next(); }, pixels);
  } else {
    std::size_t at = head->pixels_at;
    const auto next_sample = [&]() -> std::optional<unsigned> {
      unsigned value = bytes[at++];
      if (sample_bytes == 2) value = value << 8 | bytes[at++];
      return value;
    };
    enough = read_pixels(*head, next_sample, pixels);
  }
  if (!enough) return cut();
  return pixels;
}

}  // namespace slamfuse::common
