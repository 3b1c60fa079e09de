// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>

#include <fmt/format.h>

#include "service/command_line.hpp"
#include "service/progress_line.hpp"
#include "service/run_command.hpp"

namespace {

using slamfuse::common::ErrorKind;
using slamfuse::common::Result;
namespace service = slamfuse::service;

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

/// The first Ctrl-C asks for an orderly end, a second one ends the program at once.
extern "C" void request_stop(int signal) {
  stop_requested = true;
  std::signal(signal, SIG_DFL);
}

void install_signal_handlers() {
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  std::signal(SIGXFSZ, SIG_IGN);  // a file size limit is an error of write(), like a full disk
}

int exit_status_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kFailed:
      return 1;
    case ErrorKind::kUsage:
      return 2;
    case ErrorKind::kInvalidInput:
      return 3;
    case ErrorKind::kInterrupted:
      return 130;
  }
  return 1;
}

/// Carries a request out; the text is for standard output.
Result<std::string> carry_out(const service::CommandRequest& request) {
  if (const auto* run = std::get_if<service::RunRequest>(&request)) {
    std::optional<service::ProgressLine> progress;
    if (service::ProgressLine::is_wanted()) progress.emplace();
    return service::run_recording(*run, progress ? &*progress : nullptr, stop_requested);
  }
  if (const auto* align = std::get_if<service::AlignRequest>(&request)) return service::run_align(*align);
  if (const auto* evaluate = std::get_if<service::EvaluateRequest>(&request)) return service::run_evaluate(*evaluate);
  if (const auto* info = std::get_if<service::InfoRequest>(&request)) return service::run_info(*info);
  return std::get<service::PrintRequest>(request).text;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    install_signal_handlers();
    const auto request = service::parse_command_line(argc, argv);
    const auto outcome = request ? carry_out(*request) : tl::unexpected(request.error());
    if (!outcome) {
      fmt::print(stderr, "slamfuse: {}\n", outcome.error().message);
      return exit_status_of(outcome.error().kind);
    }
    fmt::print("{}", *outcome);
    return 0;
  } catch (const std::exception& exception) {
    std::fprintf(stderr, "slamfuse: internal error: %s\n", exception.what());
    return exit_status_of(ErrorKind::kFailed);
  }
}
