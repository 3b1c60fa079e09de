// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>

#include "service/pipeline_observer.hpp"

namespace slamfuse::service {

/// Shows on a terminal how far a run is, on one line of standard error that is rewritten a few times a second.
class ProgressLine : public PipelineObserver {
 public:
  ProgressLine();
  /// Clears the line.
  ~ProgressLine() override;
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void on_step(common::Nanoseconds stamp) override;

  /// Whether standard error is a terminal; in a pipe nothing is shown.
  static bool is_wanted();

 private:
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_shown_;
  std::optional<common::Nanoseconds> first_stamp_;
};

}  // namespace slamfuse::service
