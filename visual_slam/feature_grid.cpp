// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/feature_grid.hpp"

#include <algorithm>

namespace slamfuse::visual_slam {

std::vector<std::size_t> spread_features(std::span<const Eigen::Vector2d> candidates,
                                         std::span<const Eigen::Vector2d> taken, int wanted, const cv::Size& size,
                                         const FrontEndOptions& options) {
  const auto cell_of = [&](const Eigen::Vector2d& pixel) {
    const int column =
        std::clamp(static_cast<int>(pixel.x() * options.grid_columns / size.width), 0, options.grid_columns - 1);
    const int row = std::clamp(static_cast<int>(pixel.y() * options.grid_rows / size.height), 0, options.grid_rows - 1);
    return static_cast<std::size_t>(row * options.grid_columns + column);
  };
  std::vector<std::vector<std::size_t>> cells(static_cast<std::size_t>(options.grid_columns * options.grid_rows));
  std::vector<int> filled(cells.size(), 0);
  std::vector<Eigen::Vector2d> occupied(taken.begin(), taken.end());
  for (const Eigen::Vector2d& pixel : taken) ++filled[cell_of(pixel)];
  for (std::size_t i = 0; i < candidates.size(); ++i) cells[cell_of(candidates[i])].push_back(i);
  std::vector<std::size_t> next(cells.size(), 0);
  const double spacing = options.min_spacing * options.min_spacing;
  const auto is_free = [&](const Eigen::Vector2d& candidate) {
    return std::none_of(occupied.begin(), occupied.end(),
                        [&](const Eigen::Vector2d& pixel) { return (pixel - candidate).squaredNorm() < spacing; });
  };
  std::vector<std::size_t> chosen;
  for (int level = 0; static_cast<int>(chosen.size()) < wanted; ++level) {
    bool any_left = false;
    for (std::size_t cell = 0; cell < cells.size() && static_cast<int>(chosen.size()) < wanted; ++cell) {
      if (next[cell] >= cells[cell].size()) continue;
      any_left = true;
      if (filled[cell] > level) continue;
      while (next[cell] < cells[cell].size()) {
        const std::size_t candidate = cells[cell][next[cell]++];
        if (!is_free(candidates[candidate])) continue;
        chosen.push_back(candidate);
        occupied.push_back(candidates[candidate]);
        ++filled[cell];
        break;
      }
    }
    if (!any_left) break;
  }
  return chosen;
}

}  // namespace slamfuse::visual_slam
