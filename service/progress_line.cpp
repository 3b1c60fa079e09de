// SPDX-License-Identifier: BSD-3-Clause
#include "service/progress_line.hpp"

#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace slamfuse::service {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kRefresh{200};
/// Terminal codes: back to the beginning of the line, and clear it.
constexpr const char* kClearLine = "\r\x1b[K";

}  // namespace

ProgressLine::ProgressLine() : start_(Clock::now()), last_shown_(start_) {}

ProgressLine::~ProgressLine() { fmt::print(stderr, "{}", kClearLine); }

bool ProgressLine::is_wanted() { return ::isatty(STDERR_FILENO) == 1; }

void ProgressLine::on_step(common::Nanoseconds stamp) {
  if (!first_stamp_) first_stamp_ = stamp;
  const auto now = Clock::now();
  if (now - last_shown_ < kRefresh) return;
  last_shown_ = now;
  const double done = common::to_seconds(stamp - *first_stamp_);
  const double wall = std::chrono::duration<double>(now - start_).count();
  fmt::print(stderr, "{}{:.1f} s of the recording, {:.1f} times real time", kClearLine, done, done / wall);
  std::fflush(stderr);
}

}  // namespace slamfuse::service
