// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <variant>

#include "service/align_command.hpp"
#include "service/call_command.hpp"
#include "service/evaluate_command.hpp"
#include "service/info_command.hpp"
#include "service/play_command.hpp"
#include "service/record_command.hpp"
#include "service/run_request.hpp"
#include "service/serve_command.hpp"

namespace slamfuse::service {

/// Text to print and be done: --help, --version, the table of options.
struct PrintRequest {
  std::string text;
};

/// What the user asked for.
using CommandRequest = std::variant<PrintRequest, RunRequest, ServeRequest, PlayRequest, RecordRequest, CallRequest,
                                    AlignRequest, EvaluateRequest, InfoRequest>;

}  // namespace slamfuse::service
