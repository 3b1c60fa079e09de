// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/resampling.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slamfuse::laser_slam {

std::vector<double> normalized_weights(std::span<const double> log_weights) {
  std::vector<double> weights(log_weights.size(), 1.0 / static_cast<double>(log_weights.size()));
  const double largest = *std::max_element(log_weights.begin(), log_weights.end());
  if (!std::isfinite(largest)) return weights;
  std::transform(log_weights.begin(), log_weights.end(), weights.begin(),
                 [largest](double value) { return std::exp(value - largest); });
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights) weight /= sum;
  return weights;
}

double effective_number(std::span<const double> weights) {
  return 1.0 / std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0);
}

std::vector<int> systematic_resampling(std::span<const double> weights, double offset) {
  const int count = static_cast<int>(weights.size());
  std::vector<int> parents;
  parents.reserve(weights.size());
  double cumulative = 0.0;
  for (int i = 0; i < count; ++i) {
    cumulative += weights[static_cast<std::size_t>(i)] * count;
    while (static_cast<int>(parents.size()) < count && static_cast<double>(parents.size()) + offset < cumulative) {
      parents.push_back(i);
    }
  }
  // Rounding may leave the last pointer just past the sum; it belongs to the last particle with weight.
  const auto last = std::find_if(weights.rbegin(), weights.rend(), [](double weight) { return weight > 0.0; });
  parents.resize(weights.size(), static_cast<int>(weights.rend() - last) - 1);
  return parents;
}

}  // namespace slamfuse::laser_slam
