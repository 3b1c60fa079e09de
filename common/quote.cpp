// SPDX-License-Identifier: BSD-3-Clause
#include "common/quote.hpp"

namespace slamfuse::common {

std::string quote(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  constexpr unsigned char kFirstPrinting = 0x20;
  constexpr unsigned char kDelete = 0x7f;
  std::string result = "\"";
  for (const char c : text.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    // Bytes from 0x80 on are kept: they are parts of UTF-8 letters.
    result += byte < kFirstPrinting || byte == kDelete ? '?' : c;
  }
  return result + (text.size() > kLongest ? "...\"" : "\"");
}

}  // namespace slamfuse::common
