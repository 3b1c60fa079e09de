// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/curvature_filter.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace slamfuse::fusion {
namespace {

/// Whether the interior angle at `at` is below the threshold, by the law of cosines (eq. 3 with its inequality as the
/// text has it).
bool turns_back(const Eigen::Vector2d& before, const Eigen::Vector2d& at, const Eigen::Vector2d& after,
                double threshold_cosine, double min_step) {
  const double in = (at - before).norm();
  const double out = (after - at).norm();
  if (std::min(in, out) <= min_step) return false;
  const double across = (after - before).norm();
  return (in * in + out * out - across * across) / (2.0 * in * out) > threshold_cosine;
}

}  // namespace

std::vector<std::size_t> filter_by_curvature(const Points& laser, const Points& visual, double angle, double min_step) {
  assert(laser.size() == visual.size());
  const double threshold_cosine = std::cos(angle);
  std::vector<std::size_t> kept;
  kept.reserve(laser.size());
  for (std::size_t next = 0; next < laser.size(); ++next) {
    const bool drop =
        next >= 2 && (turns_back(laser[next - 2], laser[next - 1], laser[next], threshold_cosine, min_step) ||
                      turns_back(visual[next - 2], visual[next - 1], visual[next], threshold_cosine, min_step));
    if (!drop) kept.push_back(next);
  }
  return kept;
}

}  // namespace slamfuse::fusion
