// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/trajectory_image.hpp"

#include <algorithm>
#include <cmath>

namespace slamfuse::fusion {

std::optional<Eigen::Matrix4d> trajectory_image_matrix(const Points& points, double size, ImagePlane plane) {
  if (points.empty()) return std::nullopt;
  Eigen::Vector2d min = points.front();
  Eigen::Vector2d max = points.front();
  for (const Eigen::Vector2d& point : points) {
    if (!point.allFinite()) return std::nullopt;
    min = min.cwiseMin(point);
    max = max.cwiseMax(point);
  }
  const Eigen::Vector2d p = (max - min) / size;  // P_x, P_y
  if (!(p.minCoeff() > 0.0)) return std::nullopt;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(0, 0) = 1.0 / p.x();
  matrix(1, 1) = 1.0 / p.y();
  matrix(0, 3) = -min.x() / p.x();
  matrix(1, 3) = -min.y() / p.y();
  matrix(2, 3) = plane == ImagePlane::kLift ? 1.0 : 0.0;
  return matrix;
}

Eigen::Matrix4d aligned_angle_rotation(double angle) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  matrix.topLeftCorner<2, 2>() << c, -s, s, c;
  return matrix;
}

Points transformed(const Points& points, const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix2d linear = matrix.topLeftCorner<2, 2>();
  const Eigen::Vector2d translation = matrix.topRightCorner<2, 1>();
  Points result;
  result.reserve(points.size());
  for (const Eigen::Vector2d& point : points) result.push_back(linear * point + translation);
  return result;
}

}  // namespace slamfuse::fusion
