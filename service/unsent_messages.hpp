// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

#include "common/error.hpp"

namespace slamfuse::service {

/// How many messages could not be sent, and why the first could not.
struct UnsentMessages {
  std::size_t count = 0;
  std::optional<common::Error> first;

  void note(const common::Result<void>& sent) {
    if (sent) return;
    ++count;
    if (!first) first = sent.error();
  }
};

}  // namespace slamfuse::service
