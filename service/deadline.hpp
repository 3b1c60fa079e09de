// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>

namespace slamfuse::service {

/// Time left of a budget that several waits share.
class Deadline {
 public:
  explicit Deadline(double seconds) : end_(std::chrono::steady_clock::now() + Seconds(seconds)) {}

  std::chrono::nanoseconds left() const {
    const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(end_ - std::chrono::steady_clock::now());
    return std::max(left, std::chrono::nanoseconds::zero());
  }

 private:
  using Seconds = std::chrono::duration<double>;
  std::chrono::time_point<std::chrono::steady_clock, Seconds> end_;
};

}  // namespace slamfuse::service
