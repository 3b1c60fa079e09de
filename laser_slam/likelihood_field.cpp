// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/likelihood_field.hpp"

#include <algorithm>
#include <limits>

namespace slamfuse::laser_slam {
namespace {

constexpr int kOccupiedPercent = 65;
constexpr int kFreePercent = 25;

/// Squared distances along one line: the lower envelope of the parabolas f(q) + (p - q)^2. Reads `line`, writes back
/// into it. Infinite values have no parabola.
class LineTransform {
 public:
  explicit LineTransform(std::size_t longest) : vertices_(longest), bounds_(longest + 1), result_(longest) {}

  void apply(std::vector<float>& line, std::size_t count) {
    std::size_t parabolas = 0;
    for (std::size_t q = 0; q < count; ++q) {
      if (!std::isfinite(line[q])) continue;
      double from = -HUGE_VAL;
      while (parabolas > 0) {
        from = intersection(line, vertices_[parabolas - 1], q);
        if (from > bounds_[parabolas - 1]) break;
        --parabolas;
      }
      if (parabolas == 0) from = -HUGE_VAL;
      vertices_[parabolas] = q;
      bounds_[parabolas] = from;
      ++parabolas;
    }
    if (parabolas == 0) return;
    std::size_t current = 0;
    for (std::size_t p = 0; p < count; ++p) {
      while (current + 1 < parabolas && bounds_[current + 1] < static_cast<double>(p)) ++current;
      const double offset = static_cast<double>(p) - static_cast<double>(vertices_[current]);
      result_[p] = static_cast<float>(offset * offset + static_cast<double>(line[vertices_[current]]));
    }
    std::copy_n(result_.begin(), count, line.begin());
  }

 private:
  /// Where the parabola of q goes below that of the earlier v.
  static double intersection(const std::vector<float>& line, std::size_t v, std::size_t q) {
    const auto a = static_cast<double>(v);
    const auto b = static_cast<double>(q);
    return ((static_cast<double>(line[q]) + b * b) - (static_cast<double>(line[v]) + a * a)) / (2.0 * (b - a));
  }

  std::vector<std::size_t> vertices_;
  std::vector<double> bounds_;  // the parabola of vertices_[i] is lowest from bounds_[i] on
  std::vector<float> result_;
};

/// Squared distances [cells^2] to the nearest occupied cell, infinite without one.
std::vector<float> squared_distances(const common::OccupancyGrid& grid) {
  const auto width = static_cast<std::size_t>(grid.width);
  const auto height = static_cast<std::size_t>(grid.height);
  std::vector<float> field(width * height);
  std::transform(grid.cells.begin(), grid.cells.end(), field.begin(), [](std::int8_t cell) {
    return cell >= kOccupiedPercent ? 0.0F : std::numeric_limits<float>::infinity();
  });
  LineTransform transform(std::max(width, height));
  std::vector<float> line(std::max(width, height));
  for (std::size_t column = 0; column < width; ++column) {
    for (std::size_t row = 0; row < height; ++row) line[row] = field[row * width + column];
    transform.apply(line, height);
    for (std::size_t row = 0; row < height; ++row) field[row * width + column] = line[row];
  }
  for (std::size_t row = 0; row < height; ++row) {
    const auto begin = field.begin() + static_cast<std::ptrdiff_t>(row * width);
    std::copy_n(begin, width, line.begin());
    transform.apply(line, width);
    std::copy_n(line.begin(), width, begin);
  }
  return field;
}

}  // namespace

LikelihoodField::LikelihoodField(const common::OccupancyGrid& grid, double farthest)
    : resolution_(grid.resolution),
      width_(grid.width),
      height_(grid.height),
      origin_(grid.origin),
      farthest_(farthest) {
  const std::vector<float> squared = squared_distances(grid);
  codes_.resize(squared.size());
  for (std::size_t i = 0; i < squared.size(); ++i) {
    const double distance = std::min(std::sqrt(static_cast<double>(squared[i])) * resolution_, farthest_);
    // Only an occupied cell is at 0, however coarse the steps.
    const auto steps = static_cast<Code>(std::lround(distance / farthest_ * kFarthest));
    const Code code = distance > 0.0 ? std::max<Code>(1, steps) : 0;
    const bool known = grid.cells[i] >= kOccupiedPercent || (grid.cells[i] >= 0 && grid.cells[i] <= kFreePercent);
    codes_[i] = known ? code : static_cast<Code>(code | kUnknown);
  }
}

bool LikelihoodField::passes_wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double beyond) const {
  const double length = (to - from).norm();
  if (length == 0.0) return false;
  const double far = std::min(beyond, 0.99 * farthest_);  // distances end at the cap
  const int steps = static_cast<int>(std::ceil(2.0 * length / resolution_));
  const double step = length / steps;
  // In cells; rounding towards zero at the border does no harm, what is outside is far.
  const Eigen::Vector2d begin = (from - origin_) / resolution_;
  const Eigen::Vector2d stride = (to - from) / (resolution_ * steps);
  bool met = false;
  for (int i = 0; i <= steps;) {
    const Code here = code(static_cast<int>(begin.x() + i * stride.x()), static_cast<int>(begin.y() + i * stride.y()));
    const double distance = distance_of(here);
    if (met && distance >= far) return true;
    met = met || is_occupied(here);
    // The distance changes by no more than what is travelled, so the steps in between need no look.
    const double idle = (met ? far - distance : distance) - 2.0 * resolution_;
    i += idle > step ? static_cast<int>(idle / step) : 1;
  }
  return false;
}

}  // namespace slamfuse::laser_slam
