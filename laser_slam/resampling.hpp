// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

namespace slamfuse::laser_slam {

/// Weights that sum to one, from unnormalised logarithms. All -inf gives equal weights.
std::vector<double> normalized_weights(std::span<const double> log_weights);

/// N_eff = 1 / sum w^2 of normalised weights (Grisetti 2007, eq. 20).
double effective_number(std::span<const double> weights);

/// Systematic resampling: the parent of each of as many children as there are weights, in rising order. A particle of
/// weight w gets floor(w n) or ceil(w n) children. `offset` in [0, 1) is the one random number it takes.
std::vector<int> systematic_resampling(std::span<const double> weights, double offset);

}  // namespace slamfuse::laser_slam
