// SPDX-License-Identifier: BSD-3-Clause
#include "service/update_times.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace slamfuse::service {

UpdateTimes summarise_update_times(std::vector<double> milliseconds) {
  if (milliseconds.empty()) return {};
  std::sort(milliseconds.begin(), milliseconds.end());
  const auto percentile = [&](double fraction) {
    const auto rank = static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(milliseconds.size())));
    return milliseconds[std::max<std::size_t>(rank, 1) - 1];
  };
  return {percentile(0.5), percentile(0.95), percentile(0.99), milliseconds.back()};
}

}  // namespace slamfuse::service
