// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/planar_affine.hpp"

#include <cmath>

#include <Eigen/LU>

namespace slamfuse::fusion {
namespace {

/// How much closer to a right angle (cosine) the images of the target's axes must be before the stretch is put on them:
/// near quarter turns, and for equal scales, both are right and the visual map's axes are the ones to name.
constexpr double kClearlySquarer = 0.003;

}  // namespace

PlanarAffine PlanarAffine::operator*(const PlanarAffine& other) const {
  return {linear * other.linear, *this * other.translation};
}

PlanarAffine PlanarAffine::inverse() const {
  const Eigen::Matrix2d inverse_linear = linear.inverse();
  return {inverse_linear, -(inverse_linear * translation)};
}

Eigen::Matrix3d PlanarAffine::matrix() const {
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  result.topLeftCorner<2, 2>() = linear;
  result.topRightCorner<2, 1>() = translation;
  return result;
}

bool PlanarAffine::is_finite() const { return linear.allFinite() && translation.allFinite(); }

PlanarAffine to_affine(const common::Similarity2& similarity) {
  return {similarity.scale * similarity.pose.rotation(), similarity.pose.translation()};
}

AffineParts take_apart(const PlanarAffine& affine) {
  const Eigen::Matrix2d& a = affine.linear;
  AffineParts parts;
  // The polar decomposition in the plane: the rotation nearest to `a` maximises trace(R^T a).
  parts.rotation = std::atan2(a(1, 0) - a(0, 1), a(0, 0) + a(1, 1));
  parts.mean_scale = std::sqrt(std::abs(a.determinant()));
  const Eigen::Vector2d columns = a.colwise().norm().transpose();
  const Eigen::Vector2d rows = a.rowwise().norm();
  const double column_cosine = std::abs(a.col(0).dot(a.col(1))) / columns.prod();
  const double row_cosine = std::abs(a.row(0).dot(a.row(1))) / rows.prod();
  parts.scale_along_target_axes = row_cosine + kClearlySquarer < column_cosine;
  parts.scale = parts.scale_along_target_axes ? rows : columns;
  return parts;
}

}  // namespace slamfuse::fusion
