// SPDX-License-Identifier: BSD-3-Clause
#include "service/pacer.hpp"

#include <algorithm>
#include <thread>

namespace slamfuse::service {
namespace {

using Clock = std::chrono::steady_clock;

/// How long a stop request may go unnoticed while waiting.
constexpr std::chrono::milliseconds kNap{20};

}  // namespace

void Pacer::wait_for(common::Nanoseconds stamp, const std::atomic<bool>& stop) {
  if (rate_ <= 0.0) return;
  if (!first_stamp_) {
    first_stamp_ = stamp;
    start_ = Clock::now();
  }
  const std::chrono::duration<double> since_start(common::to_seconds(stamp - *first_stamp_) / rate_);
  const auto due = start_ + std::chrono::duration_cast<Clock::duration>(since_start);
  for (auto now = Clock::now(); now < due && !stop; now = Clock::now()) {
    std::this_thread::sleep_for(std::min<Clock::duration>(due - now, kNap));
  }
}

}  // namespace slamfuse::service
