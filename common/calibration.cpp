// SPDX-License-Identifier: BSD-3-Clause
#include "common/calibration.hpp"

#include <array>
#include <cmath>

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

/// Whether the distorted radius grows all the way out to r^2 = u, so that nothing from outside folds into the image:
/// its slope d(r * factor)/dr = 1 + 3 k1 u + 5 k2 u^2 + 7 k3 u^3 is positive at u and at the extrema on the way there.
bool radius_grows_up_to(const CameraCalibration& camera, double u) {
  const auto slope = [&](double at) {
    return 1.0 + at * (3.0 * camera.k1 + at * (5.0 * camera.k2 + at * 7.0 * camera.k3));
  };
  if (!(slope(u) > 0.0)) return false;
  // The extrema solve a u^2 + b u + c = 0. In this form of the roots a = 0 gives the single root and an infinity.
  const double a = 21.0 * camera.k3;
  const double b = 10.0 * camera.k2;
  const double c = 3.0 * camera.k1;
  const double discriminant = b * b - 4.0 * a * c;
  if (discriminant < 0.0) return true;
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  for (const double extremum : std::array{q / a, c / q}) {
    if (extremum > 0.0 && extremum < u && !(slope(extremum) > 0.0)) return false;
  }
  return true;
}

}  // namespace

std::optional<Eigen::Vector2d> CameraCalibration::project(const Eigen::Vector3d& point) const {
  if (!(point.z() > 1e-9)) return std::nullopt;
  const Eigen::Vector2d normalized = point.head<2>() / point.z();
  if (!radius_grows_up_to(*this, normalized.squaredNorm())) return std::nullopt;
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
