// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/robust_statistics.hpp"

#include <algorithm>

namespace slamfuse::fusion {

double tukey_weight(double square, double sigma) {
  const double u2 = square / (kTukeyConstant * kTukeyConstant * sigma * sigma);
  return u2 >= 1.0 ? 0.0 : (1.0 - u2) * (1.0 - u2);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace slamfuse::fusion
