// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <optional>

#include "common/time.hpp"

namespace slamfuse::service {

/// Holds a replay back to `rate` recording seconds in a second of wall time.
class Pacer {
 public:
  /// `rate` 0: never waits.
  explicit Pacer(double rate) : rate_(rate) {}

  /// Waits until it is time for a message of this stamp; returns at once when `stop` is set.
  void wait_for(common::Nanoseconds stamp, const std::atomic<bool>& stop);

 private:
  double rate_;
  std::optional<common::Nanoseconds> first_stamp_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace slamfuse::service
