// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/error.hpp"
#include "service/command_request.hpp"

namespace slamfuse::service {

/// Reads the command line, and the configuration file it names. Errors: kUsage for the command line itself,
/// kInvalidInput for the configuration file.
common::Result<CommandRequest> parse_command_line(int argc, const char* const* argv);

}  // namespace slamfuse::service
