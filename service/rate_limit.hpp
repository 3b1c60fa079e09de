// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <optional>

namespace slamfuse::service {

/// Lets something happen at most once a period of the wall clock.
class RateLimit {
 public:
  explicit RateLimit(double period_s) : period_(period_s) {}

  /// Whether it is time again; if so, the next period starts.
  bool due() {
    const auto now = std::chrono::steady_clock::now();
    if (last_ && now - *last_ < period_) return false;
    last_ = now;
    return true;
  }

 private:
  std::chrono::duration<double> period_;
  std::optional<std::chrono::steady_clock::time_point> last_;
};

}  // namespace slamfuse::service
