// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace slamfuse::service {

/// How long the updates of one module took [ms].
struct UpdateTimes {
  double median = 0.0;
  double p95 = 0.0;
  double p99 = 0.0;
  double max = 0.0;
};

/// Percentiles by the nearest-rank rule; all zero without a sample.
UpdateTimes summarise_update_times(std::vector<double> milliseconds);

}  // namespace slamfuse::service
