// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace slamfuse::fusion {

/// Tukey's constant for 95 % efficiency on normal residuals [standard deviations].
inline constexpr double kTukeyConstant = 4.685;

/// Tukey's biweight of a residual, given its square and the standard deviation `sigma` of good ones: 1 at 0, 0 beyond
/// kTukeyConstant standard deviations.
double tukey_weight(double square, double sigma);

/// At most `count` of the items (a vector), evenly spread and in their order: neighbours in time share their errors,
/// more of them tell nothing new.
template <class Items>
Items evenly_spread(const Items& items, std::size_t count) {
  if (items.size() <= count) return items;
  Items kept;
  kept.reserve(count);
  for (std::size_t n = 0; n < count; ++n) kept.push_back(items[n * items.size() / count]);
  return kept;
}

}  // namespace slamfuse::fusion
