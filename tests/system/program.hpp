// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace slamfuse::system {

/// How the program is started.
struct Launch {
  std::vector<std::string> arguments;
  std::optional<std::uint64_t> largest_file;  ///< bytes a file may have: writing more fails, as on a full disk
  std::optional<double> interrupt_after;      ///< [s] after the start a SIGINT is sent
};

/// What it did.
struct Outcome {
  int exit_status = -1;  ///< -1 when a signal ended it
  std::string out;       ///< standard output
  std::string err;       ///< standard error
  double seconds = 0.0;  ///< from the start, or from the SIGINT if one was sent, to the end
};

/// Runs the program under test to its end.
Outcome run_program(const Launch& launch);
Outcome run_program(const std::vector<std::string>& arguments);

}  // namespace slamfuse::system
