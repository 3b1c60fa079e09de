// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>
#include <string>
#include <system_error>
#include <type_traits>
#include <variant>

#include <fmt/format.h>

#include "common/time.hpp"
#include "service/command_line.hpp"
#include "service/forced_end.hpp"
#include "service/progress_line.hpp"
#include "service/run_command.hpp"

namespace {

using slamfuse::common::ErrorKind;
using slamfuse::common::Result;
namespace service = slamfuse::service;

std::atomic<bool> stop_requested{false};
std::atomic<bool> run_under_way{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

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

/// The first Ctrl-C asks a run for an orderly end; a second one, or one at any other time, when there is nothing to
/// save, ends the program at once.
extern "C" void request_stop(int) {
  if (!run_under_way || stop_requested.exchange(true)) std::_Exit(exit_status_of(ErrorKind::kInterrupted));
}

void install_signal_handlers() {
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  std::signal(SIGXFSZ, SIG_IGN);  // a file size limit is an error of write(), like a full disk
}

/// Nothing is left to do but to leave DDS, where a thread of the library may hang for ever.
void leave_within(double seconds, const Result<std::string>& outcome) {
  service::force_end(
      std::chrono::nanoseconds(slamfuse::common::from_seconds(seconds)),
      fmt::format("{}\nslamfuse: DDS hangs; ended {:.0f} s after everything was saved (service.dds.linger and leave)\n",
                  outcome ? *outcome : "slamfuse: " + outcome.error().message, seconds),
      exit_status_of(ErrorKind::kFailed));
}

/// Carries a request out; the text is for standard output.
Result<std::string> carry_out(const service::CommandRequest& request) {
  if (const auto* run = std::get_if<service::RunRequest>(&request)) {
    std::optional<service::ProgressLine> progress;
    if (service::ProgressLine::is_wanted()) progress.emplace();
    return service::run_recording(*run, progress ? &*progress : nullptr, stop_requested, [] { run_under_way = true; });
  }
  const auto tell = [](const std::string& news) {
    fmt::print(stderr, "slamfuse: {}\n", news);
    std::fflush(stderr);
  };
  if (const auto* record = std::get_if<service::RecordRequest>(&request)) {
    return service::run_record(*record, tell, stop_requested, [] { run_under_way = true; });
  }
  if (const auto* serve = std::get_if<service::ServeRequest>(&request)) {
    const service::DdsOptions& dds = serve->run.configuration.service.dds;
    const double patience = dds.linger + dds.leave;
    return service::run_serve(
        *serve, tell, stop_requested, [] { run_under_way = true; },
        [patience](const auto& outcome) { leave_within(patience, outcome); });
  }
  if (const auto* play = std::get_if<service::PlayRequest>(&request)) {
    return service::run_play(*play, stop_requested, [] { run_under_way = true; });
  }
  if (const auto* call = std::get_if<service::CallRequest>(&request)) return service::run_call(*call);
  if (const auto* align = std::get_if<service::AlignRequest>(&request)) return service::run_align(*align);
  if (const auto* evaluate = std::get_if<service::EvaluateRequest>(&request)) return service::run_evaluate(*evaluate);
  if (const auto* info = std::get_if<service::InfoRequest>(&request)) return service::run_info(*info);
  return std::get<service::PrintRequest>(request).text;
}

/// Prints the outcome; gives the exit status.
int print(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) return 0;
  fmt::print(stderr, "slamfuse: cannot write to standard output: {}\n", std::generic_category().message(errno));
  return exit_status_of(ErrorKind::kFailed);
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
    return print(*outcome);
  } catch (const std::exception& exception) {
    std::fprintf(stderr, "slamfuse: internal error: %s\n", exception.what());
    return exit_status_of(ErrorKind::kFailed);
  }
}
