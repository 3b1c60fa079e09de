// SPDX-License-Identifier: BSD-3-Clause
#include "common/calibration.hpp"

#include <Eigen/LU>

namespace slamfuse::common {
namespace {

/// The radial factor 1 + k1 r^2 + k2 r^4 + k3 r^6 and its derivative with respect to r^2.
struct Radial {
  double factor;
  double slope;
};

Radial radial(const CameraCalibration& camera, double r2) {
  return {1.0 + r2 * (camera.k1 + r2 * (camera.k2 + r2 * camera.k3)),
          camera.k1 + r2 * (2.0 * camera.k2 + r2 * 3.0 * camera.k3)};
}

}  // namespace

std::optional<Eigen::Vector2d> CameraCalibration::project(const Eigen::Vector3d& point) const {
  if (!(point.z() > 1e-9)) return std::nullopt;
  const Eigen::Vector2d normalized = point.head<2>() / point.z();
  const double r2 = normalized.squaredNorm();
  // d(r * factor)/dr: where it is not positive the polynomial has turned back and a far point would fold into the
  // image.
  const auto [factor, slope] = radial(*this, r2);
  if (factor + 2.0 * r2 * slope <= 0.0) return std::nullopt;
  return distort(normalized);
}

Eigen::Vector2d CameraCalibration::distort(const Eigen::Vector2d& normalized) const {
  const double x = normalized.x();
  const double y = normalized.y();
  const double r2 = normalized.squaredNorm();
  const double factor = radial(*this, r2).factor;
  const double xd = x * factor + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
  const double yd = y * factor + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
  return {fx * xd + cx, fy * yd + cy};
}

Eigen::Matrix2d CameraCalibration::distort_jacobian(const Eigen::Vector2d& normalized) const {
  const double x = normalized.x();
  const double y = normalized.y();
  const auto [factor, slope] = radial(*this, normalized.squaredNorm());
  const double cross = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
  Eigen::Matrix2d jacobian;
  jacobian << factor + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x, cross, cross,
      factor + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
  return Eigen::Vector2d(fx, fy).asDiagonal() * jacobian;
}

Eigen::Vector2d CameraCalibration::undistort(const Eigen::Vector2d& pixel) const {
  Eigen::Vector2d normalized((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  constexpr int kMaxIterations = 20;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Eigen::Vector2d step = distort_jacobian(normalized).inverse() * (pixel - distort(normalized));
    normalized += step;
    if (step.squaredNorm() < 1e-24) break;
  }
  return normalized;
}

}  // namespace slamfuse::common
