// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace slamfuse::service {

/// About `count` evenly spaced round numbers (1, 2 or 5 times a power of ten) inside [low, high]. Empty when the range
/// is empty or not finite.
std::vector<double> nice_ticks(double low, double high, int count);

/// One axis of a plot: values from `low` to `high` lie at drawing coordinates from `start` to `end`.
struct PlotAxis {
  double low = 0.0;
  double high = 1.0;
  double start = 0.0;
  double end = 1.0;

  double operator()(double value) const { return start + (value - low) / (high - low) * (end - start); }
};

/// The ticks as text, with just as many decimals as their distance needs.
std::vector<std::string> tick_labels(const std::vector<double>& ticks);

}  // namespace slamfuse::service
