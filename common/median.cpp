// SPDX-License-Identifier: BSD-3-Clause
#include "common/median.hpp"

#include <algorithm>

namespace slamfuse::common {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace slamfuse::common
