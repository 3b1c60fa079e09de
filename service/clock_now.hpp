// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

#include "common/time.hpp"

namespace slamfuse::service {

/// The machine's clock, Unix time [ns].
inline common::Nanoseconds clock_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace slamfuse::service
