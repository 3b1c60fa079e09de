// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/pyramid_filter.hpp"

#include <cassert>
#include <cmath>

namespace slamfuse::fusion {
namespace {

Eigen::Vector2d down_and_up(const Eigen::Vector2d& point, double ratio) {
  return {std::round(point.x() / ratio) * ratio, std::round(point.y() / ratio) * ratio};
}

}  // namespace

ImagePairs filter_by_pyramid(const ImagePairs& pairs, double ratio) {
  assert(pairs.laser.size() == pairs.visual.size());
  ImagePairs filtered;
  for (std::size_t i = 0; i < pairs.laser.size(); ++i) {
    const Eigen::Vector2d laser = down_and_up(pairs.laser[i], ratio);
    const Eigen::Vector2d visual = down_and_up(pairs.visual[i], ratio);
    if (!filtered.laser.empty() && filtered.laser.back() == laser && filtered.visual.back() == visual) continue;
    filtered.laser.push_back(laser);
    filtered.visual.push_back(visual);
  }
  return filtered;
}

}  // namespace slamfuse::fusion
