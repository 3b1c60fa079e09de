// SPDX-License-Identifier: BSD-3-Clause
#include "common/similarity2.hpp"

#include <cmath>

#include "common/angle.hpp"

namespace slamfuse::common {
namespace {

/// Relative to the size of the coordinates, what is smaller than this is rounding.
constexpr double kRounding = 1e-12;

/// Whether weighted points with this sum of squared distances from their mean all stand in one place.
bool coincide(double squared_spread, double total_weight, const Eigen::Vector2d& mean) {
  return !(std::sqrt(squared_spread / total_weight) > kRounding * mean.norm()) || !(squared_spread > 0.0);
}

}  // namespace

Eigen::Vector2d Similarity2::operator*(const Eigen::Vector2d& point) const {
  return scale * (pose.rotation() * point) + pose.translation();
}

Pose2 Similarity2::operator*(const Pose2& other) const {
  const Eigen::Vector2d position = *this * other.translation();
  return {position.x(), position.y(), normalize_angle(pose.theta + other.theta)};
}

Similarity2 Similarity2::operator*(const Similarity2& other) const { return {scale * other.scale, *this * other.pose}; }

Similarity2 Similarity2::inverse() const {
  const Pose2 inverse_pose = pose.inverse();
  return {1.0 / scale, {inverse_pose.x / scale, inverse_pose.y / scale, inverse_pose.theta}};
}

Eigen::Matrix3d Similarity2::matrix() const {
  Eigen::Matrix3d result = pose.matrix();
  result.topLeftCorner<2, 2>() *= scale;
  return result;
}

std::optional<Similarity2> fit_similarity(std::span<const Eigen::Vector2d> source,
                                          std::span<const Eigen::Vector2d> target, FitGroup group,
                                          std::span<const double> weights) {
  if (source.size() != target.size() || source.size() < 2) return std::nullopt;
  if (!weights.empty() && weights.size() != source.size()) return std::nullopt;
  const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };

  double total = 0.0;
  Eigen::Vector2d source_mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d target_mean = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < source.size(); ++i) {
    total += weight(i);
    source_mean += weight(i) * source[i];
    target_mean += weight(i) * target[i];
  }
  if (!(total > 0.0)) return std::nullopt;
  source_mean /= total;
  target_mean /= total;

  // In the plane the singular value decomposition of Umeyama reduces to the angle of one complex correlation.
  double along = 0.0;
  double across = 0.0;
  double source_spread = 0.0;
  double target_spread = 0.0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector2d s = source[i] - source_mean;
    const Eigen::Vector2d t = target[i] - target_mean;
    along += weight(i) * s.dot(t);
    across += weight(i) * (s.x() * t.y() - s.y() * t.x());
    source_spread += weight(i) * s.squaredNorm();
    target_spread += weight(i) * t.squaredNorm();
  }
  const double correlation = std::hypot(along, across);
  if (coincide(source_spread, total, source_mean) || coincide(target_spread, total, target_mean)) return std::nullopt;
  // Without correlation (a mirrored circle) every angle fits equally badly.
  if (!(correlation > kRounding * std::sqrt(source_spread * target_spread))) return std::nullopt;

  Similarity2 result;
  result.scale = group == FitGroup::kSimilarity ? correlation / source_spread : 1.0;
  result.pose.theta = normalize_angle(std::atan2(across, along));
  const Eigen::Vector2d translation = target_mean - result.scale * (result.pose.rotation() * source_mean);
  result.pose.x = translation.x();
  result.pose.y = translation.y();
  return result;
}

}  // namespace slamfuse::common
