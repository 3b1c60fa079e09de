// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/aligned_angle_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include <Eigen/LU>

#include "common/angle.hpp"
#include "fusion/robust_statistics.hpp"

namespace slamfuse::fusion {
namespace {

/// A sum of distances may come out this much below its exact lower bound by rounding.
constexpr double kRounding = 1.0 - 1e-10;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A rotated and rescaled image as one affine map of the image it came from: x' = a x + b y + c, y' = d x + e y + f.
struct RotatedImage {
  double a, b, c, d, e, f;

  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const {
    return {a * p.x() + b * p.y() + c, d * p.x() + e * p.y() + f};
  }
};

/// The convex hull by Andrew's monotone chain. Its corners alone decide the extents of a rotated image.
Points convex_hull(Points points) {
  const auto less = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
    return p.x() < q.x() || (p.x() == q.x() && p.y() < q.y());
  };
  std::sort(points.begin(), points.end(), less);
  const auto turns_left = [](const Eigen::Vector2d& o, const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
    return (p.x() - o.x()) * (q.y() - o.y()) - (p.y() - o.y()) * (q.x() - o.x()) > 0.0;
  };
  Points hull;
  const auto extend = [&](const Eigen::Vector2d& point, std::size_t bottom) {
    while (hull.size() >= bottom + 2 && !turns_left(hull[hull.size() - 2], hull.back(), point)) hull.pop_back();
    hull.push_back(point);
  };
  for (const Eigen::Vector2d& point : points) extend(point, 0);
  const std::size_t lower = hull.size() - 1;
  for (auto point = points.rbegin(); point != points.rend(); ++point) extend(*point, lower);
  return hull;
}

/// The images at 0, step, 2 step, ... Empty when one has no extent.
std::vector<RotatedImage> rotated_images(const Points& points, double size, double step, int count) {
  const Points hull = convex_hull(points);
  std::vector<RotatedImage> images;
  images.reserve(static_cast<std::size_t>(count));
  for (int n = 0; n < count; ++n) {
    const Eigen::Matrix4d rotation = aligned_angle_rotation(step * n);
    const auto fill = trajectory_image_matrix(transformed(hull, rotation), size, ImagePlane::kKeep);
    if (!fill) return {};
    const Eigen::Matrix4d m = *fill * rotation;
    images.push_back({m(0, 0), m(0, 1), m(0, 3), m(1, 0), m(1, 1), m(1, 3)});
  }
  return images;
}

using Blocks = std::vector<std::vector<std::size_t>>;  ///< indices of paired points

/// Blocks of paired points that lie near each other in both images: all points, halved `times` times, each time along
/// the coordinate of the four that is the most spread.
Blocks blocks_of_neighbours(const Points& laser, const Points& visual, int times) {
  const auto coordinate = [&](std::size_t i, int axis) { return axis < 2 ? laser[i][axis] : visual[i][axis - 2]; };
  Blocks blocks(1);
  blocks.front().resize(laser.size());
  std::iota(blocks.front().begin(), blocks.front().end(), std::size_t{0});
  for (int n = 0; n < times; ++n) {
    Blocks halves;
    for (std::vector<std::size_t>& block : blocks) {
      Eigen::Vector4d sum = Eigen::Vector4d::Zero();
      Eigen::Vector4d squares = Eigen::Vector4d::Zero();
      for (const std::size_t i : block) {
        const Eigen::Vector4d both(laser[i].x(), laser[i].y(), visual[i].x(), visual[i].y());
        sum += both;
        squares += both.cwiseAbs2();
      }
      int axis = 0;
      (squares - sum.cwiseAbs2() / static_cast<double>(block.size())).maxCoeff(&axis);
      const auto middle = block.begin() + static_cast<std::ptrdiff_t>(block.size() / 2);
      const auto less = [&](std::size_t i, std::size_t j) { return coordinate(i, axis) < coordinate(j, axis); };
      std::nth_element(block.begin(), middle, block.end(), less);
      if (middle != block.begin()) halves.emplace_back(block.begin(), middle);
      halves.emplace_back(middle, block.end());
    }
    blocks = std::move(halves);
  }
  return blocks;
}

/// Block means of the paired points under every rotation. The distance of two block means times the block's size is at
/// most the sum of the block's distances (triangle inequality), whatever the affine maps and the blocks; it is near to
/// it where the differences within a block point the same way.
class BlockBound {
 public:
  BlockBound(const Points& laser, const std::vector<RotatedImage>& laser_images, const Points& visual,
             const std::vector<RotatedImage>& visual_images, const Blocks& blocks)
      : blocks_(blocks.size()) {
    for (const auto& block : blocks) weights_.push_back(static_cast<double>(block.size()));
    laser_ = rotated_means(laser, laser_images, blocks);
    visual_ = rotated_means(visual, visual_images, blocks);
  }

  double operator()(std::size_t laser_angle, std::size_t visual_angle) const {
    const Eigen::Vector2d* l = &laser_[laser_angle * blocks_];
    const Eigen::Vector2d* v = &visual_[visual_angle * blocks_];
    double bound = 0.0;
    for (std::size_t b = 0; b < blocks_; ++b) bound += weights_[b] * (l[b] - v[b]).norm();
    return bound * kRounding;
  }

 private:
  static Points rotated_means(const Points& points, const std::vector<RotatedImage>& images, const Blocks& blocks) {
    Points means;
    for (const auto& block : blocks) {
      Eigen::Vector2d sum = Eigen::Vector2d::Zero();
      for (const std::size_t i : block) sum += points[i];
      means.push_back(sum / static_cast<double>(block.size()));
    }
    Points rotated;
    rotated.reserve(images.size() * means.size());
    for (const RotatedImage& image : images) {
      for (const Eigen::Vector2d& mean : means) rotated.push_back(image(mean));
    }
    return rotated;
  }

  std::size_t blocks_;
  std::vector<double> weights_;
  Points laser_;
  Points visual_;
};

/// Paired points, coordinate by coordinate.
struct PairedPoints {
  Eigen::ArrayXd laser_x, laser_y, visual_x, visual_y;

  PairedPoints(const Points& laser, const Points& visual) {
    const auto split = [](const Points& points, Eigen::ArrayXd& x, Eigen::ArrayXd& y) {
      const Eigen::Map<const Eigen::Array2Xd> both(points.front().data(), 2, static_cast<Eigen::Index>(points.size()));
      x = both.row(0).transpose();
      y = both.row(1).transpose();
    };
    split(laser, laser_x, laser_y);
    split(visual, visual_x, visual_y);
  }
};

/// Sum of distances of the paired points, given up once it exceeds `limit`.
double summed_distance(const PairedPoints& pairs, const RotatedImage& laser, const RotatedImage& visual, double limit) {
  constexpr Eigen::Index kStride = 64;
  const Eigen::Index count = pairs.laser_x.size();
  double sum = 0.0;
  for (Eigen::Index i = 0; i < count; i += kStride) {
    const Eigen::Index n = std::min(kStride, count - i);
    const auto lx = pairs.laser_x.segment(i, n);
    const auto ly = pairs.laser_y.segment(i, n);
    const auto vx = pairs.visual_x.segment(i, n);
    const auto vy = pairs.visual_y.segment(i, n);
    sum += ((laser.a * lx + laser.b * ly - visual.a * vx - visual.b * vy + (laser.c - visual.c)).square() +
            (laser.d * lx + laser.e * ly - visual.d * vx - visual.e * vy + (laser.f - visual.f)).square())
               .sqrt()
               .sum();
    if (sum > limit) return kInfinity;
  }
  return sum;
}

/// The rotation between the images that two angles imply: that nearest to (laser image)^-1 (visual image).
double implied_rotation(const RotatedImage& laser, const RotatedImage& visual) {
  Eigen::Matrix2d l;
  Eigen::Matrix2d v;
  l << laser.a, laser.b, laser.d, laser.e;
  v << visual.a, visual.b, visual.d, visual.e;
  const Eigen::Matrix2d m = l.inverse() * v;
  return std::atan2(m(1, 0) - m(0, 1), m(0, 0) + m(1, 1));
}

struct Candidate {
  std::size_t laser = 0;
  std::size_t visual = 0;
  double sum = kInfinity;
};

}  // namespace

std::optional<AlignedAngles> search_aligned_angles(const Points& laser, const Points& visual, double size, double step,
                                                   double separation) {
  constexpr int kCoarseHalvings = 4;
  constexpr int kFineHalvings = 8;
  constexpr std::size_t kCoarseStride = 6;
  constexpr std::size_t kRunnerUpStride = 3;
  constexpr std::size_t kFewPoints = 200;
  if (laser.empty() || laser.size() != visual.size()) return std::nullopt;
  const int quarter = static_cast<int>(std::lround(0.5 * std::numbers::pi / step));
  const std::vector<RotatedImage> laser_images = rotated_images(laser, size, step, quarter);
  const std::vector<RotatedImage> visual_images = rotated_images(visual, size, step, 4 * quarter);
  if (laser_images.empty() || visual_images.empty()) return std::nullopt;
  const PairedPoints pairs(laser, visual);
  const PairedPoints few(evenly_spread(laser, kFewPoints), evenly_spread(visual, kFewPoints));
  const Blocks coarse_blocks = blocks_of_neighbours(laser, visual, kCoarseHalvings);
  const Blocks fine_blocks = blocks_of_neighbours(laser, visual, kFineHalvings);
  const BlockBound coarse_bound(laser, laser_images, visual, visual_images, coarse_blocks);
  const BlockBound fine_bound(laser, laser_images, visual, visual_images, fine_blocks);

  // A pair of angles that is likely good: the best for a few of the points on a grid that may be coarser.
  const auto guess = [&](std::size_t stride, const auto& admit) {
    Candidate best;
    for (std::size_t l = 0; l < laser_images.size(); l += stride) {
      for (std::size_t v = 0; v < visual_images.size(); v += stride) {
        const double sum = summed_distance(few, laser_images[l], visual_images[v], best.sum);
        if (sum < best.sum && admit(l, v)) best = {l, v, sum};
      }
    }
    return best;
  };
  // The best of all pairs of angles that `admit` lets pass; of equal ones the first in the order of the loops.
  const auto search = [&](std::size_t stride, std::size_t guess_stride, const auto& admit) {
    Candidate best = guess(guess_stride, admit);
    if (!(best.sum < kInfinity)) return best;
    best.sum = summed_distance(pairs, laser_images[best.laser], visual_images[best.visual], kInfinity);
    for (std::size_t l = 0; l < laser_images.size(); l += stride) {
      for (std::size_t v = 0; v < visual_images.size(); v += stride) {
        if (coarse_bound(l, v) > best.sum || fine_bound(l, v) > best.sum || !admit(l, v)) continue;
        const double sum = summed_distance(pairs, laser_images[l], visual_images[v], best.sum);
        const bool earlier = l < best.laser || (l == best.laser && v < best.visual);
        if (sum < best.sum || (sum == best.sum && earlier)) best = {l, v, sum};
      }
    }
    return best;
  };

  const Candidate best = search(1, kCoarseStride, [](std::size_t, std::size_t) { return true; });
  const double rotation = implied_rotation(laser_images[best.laser], visual_images[best.visual]);
  const Candidate runner_up = search(kRunnerUpStride, kRunnerUpStride, [&](std::size_t l, std::size_t v) {
    const double other = implied_rotation(laser_images[l], visual_images[v]);
    return std::abs(common::angle_difference(other, rotation)) > separation;
  });
  const double count = static_cast<double>(laser.size());
  return AlignedAngles{step * static_cast<double>(best.laser), step * static_cast<double>(best.visual),
                       best.sum / count, runner_up.sum / count};
}

}  // namespace slamfuse::fusion
