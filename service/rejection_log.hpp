// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/pose_estimate.hpp"
#include "common/recording.hpp"

namespace slamfuse::service {

/// Turns rejected messages into few events: a broken camera must not flood the report. Messages of one sensor whose
/// reasons differ only in figures (line, stamp, value) count as one kind. Beyond kMostKinds, as when a sender makes up
/// ever new texts, further kinds of a sensor count as one.
class RejectionLog {
 public:
  static constexpr std::size_t kMostKinds = 200;

  /// The event for the first of its kind; nothing for the ones after it.
  std::optional<common::Event> add(const common::RejectedMessage& message);
  /// One event for each kind that came more than once: how often, and the first and last time.
  std::vector<common::Event> summary() const;

 private:
  struct Kind {
    std::int64_t count = 0;
    common::RejectedMessage first;
    common::Nanoseconds last_stamp = 0;
  };
  std::map<std::pair<std::string, std::string>, Kind> kinds_;  // by sensor and reason without figures
};

}  // namespace slamfuse::service
