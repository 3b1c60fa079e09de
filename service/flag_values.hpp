// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/error.hpp"

namespace slamfuse::service {

/// More threads than this are a typing error.
inline constexpr int kMaxThreads = 256;

/// A finite number from `smallest` on; CLI11's own range check lets NaN pass.
CLI::Validator finite_from(double smallest);

/// A seed; CLI11 would take -1 for the largest number there is.
CLI::Validator whole_number();

/// "SENSOR=SECONDS" texts of a flag as a map. Error (kUsage): another form, a number that is not finite or below
/// `smallest`, a sensor given twice.
common::Result<std::map<std::string, double>> parse_seconds_by_sensor(const char* flag,
                                                                      const std::vector<std::string>& texts,
                                                                      double smallest);

}  // namespace slamfuse::service
