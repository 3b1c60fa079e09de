// SPDX-License-Identifier: BSD-3-Clause
#include "common/time.hpp"

#include <cmath>
#include <cstdlib>

namespace slamfuse::common {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

Nanoseconds from_seconds(double seconds) {
  return static_cast<Nanoseconds>(std::llround(seconds * static_cast<double>(kNanosecondsPerSecond)));
}

std::optional<Nanoseconds> parse_decimal_seconds(std::string_view text) {
  std::size_t at = 0;
  bool negative = false;
  if (at < text.size() && (text[at] == '-' || text[at] == '+')) negative = text[at++] == '-';

  // Collect the digits and where the decimal point falls among them, then apply the exponent by moving the point.
  std::string digits;
  int point = -1;
  for (; at < text.size() && (is_digit(text[at]) || text[at] == '.'); ++at) {
    if (text[at] == '.') {
      if (point >= 0) return std::nullopt;
      point = static_cast<int>(digits.size());
    } else {
      digits += text[at];
    }
  }
  if (digits.empty() || digits.size() > 64) return std::nullopt;
  if (point < 0) point = static_cast<int>(digits.size());
  if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    ++at;
    bool negative_exponent = false;
    if (at < text.size() && (text[at] == '-' || text[at] == '+')) negative_exponent = text[at++] == '-';
    int exponent = 0;
    int exponent_digits = 0;
    for (; at < text.size() && is_digit(text[at]) && exponent_digits < 4; ++at, ++exponent_digits) {
      exponent = exponent * 10 + (text[at] - '0');
    }
    if (exponent_digits == 0) return std::nullopt;
    point += negative_exponent ? -exponent : exponent;
  }
  if (at != text.size()) return std::nullopt;

  // The value in nanoseconds is the digits before position point + 9.
  const int end = point + 9;
  Nanoseconds value = 0;
  for (int i = 0; i < end; ++i) {
    const Nanoseconds digit = i < static_cast<int>(digits.size()) ? digits[static_cast<std::size_t>(i)] - '0' : 0;
    if (value > (kLatestStamp - digit) / 10) return std::nullopt;
    value = value * 10 + digit;
    if (value == 0 && i >= static_cast<int>(digits.size())) break;
  }
  return negative ? -value : value;
}

std::string format_seconds(Nanoseconds time) {
  const std::lldiv_t parts = std::lldiv(time, kNanosecondsPerSecond);
  std::string decimals = std::to_string(std::llabs(parts.rem));
  decimals.insert(0, 9 - decimals.size(), '0');
  return (time < 0 ? "-" : "") + std::to_string(std::llabs(parts.quot)) + "." + decimals;
}

}  // namespace slamfuse::common
