// SPDX-License-Identifier: BSD-3-Clause
#include "common/option_range.hpp"

#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace slamfuse::common {
namespace {

/// A bound this large was meant as "none".
constexpr double kUnbounded = 1e300;

std::string between(const std::string& min, const std::string& max, bool has_min, bool has_max,
                    const std::string& unit) {
  const std::string suffix = unit.empty() ? "" : " " + unit;
  if (has_min && has_max) return fmt::format("{} to {}{}", min, max, suffix);
  if (has_min) return fmt::format("at least {}{}", min, suffix);
  if (has_max) return fmt::format("at most {}{}", max, suffix);
  return "any" + suffix;
}

}  // namespace

std::string range_text(OptionVisitor::Range<double> range, const std::string& unit) {
  return between(real_text(range.min), real_text(range.max), range.min > -kUnbounded, range.max < kUnbounded, unit);
}

std::string range_text(OptionVisitor::Range<int> range, const std::string& unit) {
  using Limits = std::numeric_limits<int>;
  return between(std::to_string(range.min), std::to_string(range.max), range.min != Limits::min(),
                 range.max != Limits::max(), unit);
}

std::string real_text(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

}  // namespace slamfuse::common
