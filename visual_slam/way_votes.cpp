// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/way_votes.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace slamfuse::visual_slam {
namespace {

constexpr double kFloor = 0.35;  // of the patches
constexpr double kAbove = 0.4;
constexpr double kAnything = 1.0 - kFloor - kAbove;
// Patches overlap, and what is wrong with one is wrong with its neighbours: they say as much as so many independent
// ones.
constexpr double kIndependent = 0.2;

constexpr double kStep = 0.002;  // between ways that are tried [m]
constexpr double kSame = 0.012;  // ways no farther apart are one [m]
constexpr double kSure = 0.99;
constexpr double kEnd = 0.004;  // a way so near the end of the range may lie beyond [m]
constexpr int kRounds = 5;      // in which the way is made exact

double floor_density(const WayVote& vote, double way) {
  const double off = (vote.way - way) / vote.sigma;
  return kFloor * std::exp(-0.5 * off * off) / (vote.sigma * std::sqrt(2.0 * std::numbers::pi));
}

double density(const WayVote& vote, double way, double width) {
  // Something at height z under a camera at height h seems to move by s = w h / (h - z). With w / s spread evenly, the
  // density of s is w / s^2; what would be beyond the range is left out, about.
  const double share = way / vote.way;
  const double above =
      share > 0.0 && share < 1.0 ? std::abs(share / vote.way) / std::max(0.1, 1.0 - std::abs(way) / width) : 0.0;
  return floor_density(vote, way) + kAbove * above + kAnything / width;
}

/// The mean of the votes, each as far as it is the floor's if this was the way.
double mean_of_floor(std::span<const WayVote> votes, double way, double width) {
  double information = 0.0;
  double sum = 0.0;
  for (const WayVote& vote : votes) {
    const double weight = floor_density(vote, way) / density(vote, way, width) / (vote.sigma * vote.sigma);
    information += weight;
    sum += weight * vote.way;
  }
  return information > 0.0 ? sum / information : way;
}

}  // namespace

std::optional<double> likeliest_way(std::span<const WayVote> votes, const WayRange& range) {
  const double width = range.most - range.least;
  const int steps = std::max(8, static_cast<int>(std::ceil(width / kStep)));
  const double step = width / steps;
  std::vector<double> logarithms;
  for (int i = 0; i <= steps; ++i) {
    double sum = 0.0;
    for (const WayVote& vote : votes) sum += std::log(density(vote, range.least + i * step, width));
    logarithms.push_back(kIndependent * sum);
  }
  const auto top = std::max_element(logarithms.begin(), logarithms.end());
  const auto best = static_cast<int>(top - logarithms.begin());
  const double end = std::min(kEnd, 0.1 * width);
  if (std::min(best, steps - best) * step < end) return std::nullopt;
  double all = 0.0;
  double here = 0.0;
  for (int i = 0; i <= steps; ++i) {
    const double probability = std::exp(logarithms[static_cast<std::size_t>(i)] - *top);
    all += probability;
    if (std::abs(i - best) * step <= kSame) here += probability;
  }
  if (here < kSure * all) return std::nullopt;
  double way = range.least + best * step;
  for (int round = 0; round < kRounds; ++round) way = mean_of_floor(votes, way, width);
  return way;
}

}  // namespace slamfuse::visual_slam
