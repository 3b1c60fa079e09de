// SPDX-License-Identifier: BSD-3-Clause
#include "service/flag_values.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace slamfuse::service {

using common::Result;

CLI::Validator finite_from(double smallest) {
  return CLI::Validator(
      [smallest](const std::string& text) {
        double value = 0.0;
        if (CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= smallest) return std::string();
        return fmt::format("{} is not a number from {} on", text, smallest);
      },
      fmt::format("FLOAT >= {}", smallest));
}

CLI::Validator whole_number() {
  return CLI::Validator(
      [](const std::string& text) {
        const bool good =
            !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
        return good ? std::string() : text + " is not a whole number from 0 on";
      },
      "UINT");
}

Result<std::map<std::string, double>> parse_seconds_by_sensor(const char* flag, const std::vector<std::string>& texts,
                                                              double smallest) {
  std::map<std::string, double> seconds;
  for (const auto& text : texts) {
    const std::size_t equals = text.rfind('=');
    double value = 0.0;
    const bool good = equals != std::string::npos && equals > 0 &&
                      CLI::detail::lexical_cast(text.substr(equals + 1), value) && std::isfinite(value) &&
                      value >= smallest;
    if (!good) {
      return common::usage_error(
          fmt::format("{} {}: must be SENSOR=SECONDS{}", flag, text, smallest >= 0.0 ? ", not negative" : ""));
    }
    if (!seconds.emplace(text.substr(0, equals), value).second) {
      return common::usage_error(fmt::format("{} {}: the sensor was given twice", flag, text));
    }
  }
  return seconds;
}

}  // namespace slamfuse::service
