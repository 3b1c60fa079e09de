// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/aligned_angle_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/LU>

#include "common/angle.hpp"

namespace slamfuse::fusion {
namespace {

/// A sum of distances may come out this much below its exact lower bound by rounding.
constexpr double kRounding = 1.0 - 1e-10;

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

/// Block means of the paired points under every rotation. The distance of two block means times the block's size is at
/// most the sum of the block's distances (triangle inequality), whatever the affine maps.
class BlockBound {
 public:
  BlockBound(const Points& laser, const std::vector<RotatedImage>& laser_images, const Points& visual,
             const std::vector<RotatedImage>& visual_images, std::size_t blocks)
      : blocks_(std::min(blocks, laser.size())) {
    for (std::size_t b = 0; b < blocks_; ++b) {
      weights_.push_back(static_cast<double>(begin(b + 1, laser.size()) - begin(b, laser.size())));
    }
    laser_ = rotated_means(laser, laser_images);
    visual_ = rotated_means(visual, visual_images);
  }

  double operator()(std::size_t laser_angle, std::size_t visual_angle) const {
    const Eigen::Vector2d* l = &laser_[laser_angle * blocks_];
    const Eigen::Vector2d* v = &visual_[visual_angle * blocks_];
    double bound = 0.0;
    for (std::size_t b = 0; b < blocks_; ++b) bound += weights_[b] * (l[b] - v[b]).norm();
    return bound * kRounding;
  }

 private:
  std::size_t begin(std::size_t block, std::size_t count) const { return block * count / blocks_; }

  Points rotated_means(const Points& points, const std::vector<RotatedImage>& images) const {
    Points means(blocks_, Eigen::Vector2d::Zero());
    std::size_t i = 0;
    for (std::size_t b = 0; b < blocks_; ++b) {
      for (; i < begin(b + 1, points.size()); ++i) means[b] += points[i];
      means[b] /= weights_[b];
    }
    Points rotated;
    rotated.reserve(images.size() * blocks_);
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

/// Sum of distances of the paired points, given up once it exceeds `limit`.
double summed_distance(const Points& laser, const RotatedImage& laser_image, const Points& visual,
                       const RotatedImage& visual_image, double limit) {
  constexpr std::size_t kStride = 64;
  double sum = 0.0;
  for (std::size_t i = 0; i < laser.size();) {
    const std::size_t stop = std::min(i + kStride, laser.size());
    for (; i < stop; ++i) sum += (laser_image(laser[i]) - visual_image(visual[i])).norm();
    if (sum > limit) return std::numeric_limits<double>::infinity();
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
  double sum = std::numeric_limits<double>::infinity();
};

}  // namespace

std::optional<AlignedAngles> search_aligned_angles(const Points& laser, const Points& visual, double size, double step,
                                                   double separation) {
  constexpr std::size_t kCoarseBlocks = 8;
  constexpr std::size_t kFineBlocks = 64;
  constexpr std::size_t kCoarseStride = 6;
  constexpr std::size_t kRunnerUpStride = 3;
  if (laser.empty() || laser.size() != visual.size()) return std::nullopt;
  const int quarter = static_cast<int>(std::lround(0.5 * std::numbers::pi / step));
  const std::vector<RotatedImage> laser_images = rotated_images(laser, size, step, quarter);
  const std::vector<RotatedImage> visual_images = rotated_images(visual, size, step, 4 * quarter);
  if (laser_images.empty() || visual_images.empty()) return std::nullopt;
  const BlockBound coarse_bound(laser, laser_images, visual, visual_images, kCoarseBlocks);
  const BlockBound fine_bound(laser, laser_images, visual, visual_images, kFineBlocks);

  // The best of all pairs of angles that `admit` lets pass; of equal ones the first in the order of the loops.
  const auto search = [&](std::size_t finest_stride, const auto& admit) {
    Candidate best;
    const auto scan = [&](std::size_t stride) {
      for (std::size_t l = 0; l < laser_images.size(); l += stride) {
        for (std::size_t v = 0; v < visual_images.size(); v += stride) {
          if (coarse_bound(l, v) > best.sum || fine_bound(l, v) > best.sum || !admit(l, v)) continue;
          const double sum = summed_distance(laser, laser_images[l], visual, visual_images[v], best.sum);
          const bool earlier = l < best.laser || (l == best.laser && v < best.visual);
          if (sum < best.sum || (sum == best.sum && earlier)) best = {l, v, sum};
        }
      }
    };
    scan(kCoarseStride);  // for a good bound early
    scan(finest_stride);
    return best;
  };

  const Candidate best = search(1, [](std::size_t, std::size_t) { return true; });
  const double rotation = implied_rotation(laser_images[best.laser], visual_images[best.visual]);
  const Candidate runner_up = search(kRunnerUpStride, [&](std::size_t l, std::size_t v) {
    const double other = implied_rotation(laser_images[l], visual_images[v]);
    return std::abs(common::angle_difference(other, rotation)) > separation;
  });
  const double count = static_cast<double>(laser.size());
  return AlignedAngles{step * static_cast<double>(best.laser), step * static_cast<double>(best.visual),
                       best.sum / count, runner_up.sum / count};
}

}  // namespace slamfuse::fusion
