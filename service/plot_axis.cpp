// SPDX-License-Identifier: BSD-3-Clause
#include "service/plot_axis.hpp"

#include <algorithm>
#include <cmath>

#include "service/markup.hpp"

namespace slamfuse::service {

std::vector<double> nice_ticks(double low, double high, int count) {
  if (!std::isfinite(low) || !std::isfinite(high) || !(high > low) || count < 1) return {};
  const double raw = (high - low) / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  const double ratio = raw / power;  // in [1, 10)
  const double step = power * (ratio < 1.5 ? 1.0 : ratio < 3.5 ? 2.0 : ratio < 7.5 ? 5.0 : 10.0);
  if (!(step > 0.0) || !std::isfinite(step)) return {};
  const double slack = 1e-9;  // of a step: keeps a tick that rounding put just outside
  std::vector<double> ticks;
  for (double k = std::ceil(low / step - slack); k <= high / step + slack; ++k) {
    ticks.push_back(k == 0.0 ? 0.0 : k * step);  // never -0
    if (ticks.size() > 100) return {};           // a range too narrow for its distance from zero
  }
  return ticks;
}

std::vector<std::string> tick_labels(const std::vector<double>& ticks) {
  std::vector<std::string> labels;
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0;
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  for (const double tick : ticks) labels.push_back(number(tick, decimals));
  return labels;
}

}  // namespace slamfuse::service
