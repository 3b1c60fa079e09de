// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>

#include "common/time.hpp"
#include "service/thinned_series.hpp"

namespace slamfuse::service {

/// How long one input took.
struct UpdateTime {
  common::Nanoseconds stamp = 0;
  double milliseconds = 0.0;
};

/// What went into a module and what came out. For the laser and the visual module the inputs are its scans or images
/// (wheel odometry is not counted), for the fusion every odometry message and every estimate.
struct ModuleCounters {
  std::size_t inputs = 0;             ///< that arrived for it, the dropped and the rejected included
  std::size_t poses = 0;              ///< made, whatever their state
  std::size_t dropped = 0;            ///< not delivered because its queue was full; a replay waits instead
  std::size_t rejected = 0;           ///< unusable, found by the reader or by the module
  ThinnedSeries<UpdateTime> updates;  ///< of the processed inputs
  double slowest_ms = 0.0;            ///< of all of them

  void updated(const UpdateTime& update) {
    updates.push(update);
    slowest_ms = std::max(slowest_ms, update.milliseconds);
  }
};

}  // namespace slamfuse::service
