// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/view_cone.hpp"

#include <algorithm>
#include <limits>
#include <optional>

namespace slamfuse::visual_slam {
namespace {

constexpr double kMargin = 1.1;     // on the widest ray, which is looked for at a few pixels only
constexpr double kSamePixel = 0.1;  // [px]

/// The square of the widest ray over that of its depth; infinite when the lens model does not reach the corners.
double widest_ray(const Camera& camera) {
  const double right = camera.calibration.width - 1.0;
  const double bottom = camera.calibration.height - 1.0;
  double widest = 0.0;
  for (const double x : {0.0, 0.5 * right, right}) {
    for (const double y : {0.0, 0.5 * bottom, bottom}) {
      const Eigen::Vector2d pixel(x, y);
      const Eigen::Vector3d ray = camera.calibration.undistort(pixel).homogeneous();
      const std::optional<Eigen::Vector2d> again = camera.calibration.project(ray);
      if (!again || !((*again - pixel).norm() < kSamePixel)) return std::numeric_limits<double>::infinity();
      widest = std::max(widest, ray.squaredNorm());
    }
  }
  return kMargin * widest;
}

}  // namespace

ViewCone::ViewCone(const Camera& camera, const Eigen::Vector3d& centre, const Eigen::Vector3d& axis)
    : centre_(centre), axis_(axis), widest_(widest_ray(camera)) {}

}  // namespace slamfuse::visual_slam
