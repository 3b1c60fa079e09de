// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/robust_statistics.hpp"

namespace slamfuse::fusion {

double tukey_weight(double square, double sigma) {
  const double u2 = square / (kTukeyConstant * kTukeyConstant * sigma * sigma);
  return u2 >= 1.0 ? 0.0 : (1.0 - u2) * (1.0 - u2);
}

}  // namespace slamfuse::fusion
