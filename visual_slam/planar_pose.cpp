// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/planar_pose.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "common/angle.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;

constexpr int kHeadings = 24;  // looked at before Newton's method
constexpr double kHeadingStep = 2.0 * std::numbers::pi / kHeadings;
constexpr int kNewtonSteps = 4;       // it is quadratic near the minimum
constexpr int kRefinements = 8;       // steps of least squares
constexpr double kLargestMiss = 0.1;  // of the distance, for two sights to agree
constexpr double kConverged = 1e-8;

/// Two unit vectors across a ray, the first horizontal.
std::array<Eigen::Vector3d, 2> across(const Eigen::Vector3d& ray) {
  Eigen::Vector3d level(-ray.y(), ray.x(), 0.0);
  if (level.squaredNorm() < 1e-12) level = Eigen::Vector3d::UnitX();
  level.normalize();
  return {level, ray.cross(level)};
}

}  // namespace

Eigen::Vector3d line_of_sight(const Sight& sight, const Pose2& pose) {
  const double c = std::cos(pose.theta), s = std::sin(pose.theta);
  const double dx = sight.landmark.x() - pose.x, dy = sight.landmark.y() - pose.y;
  return {c * dx + s * dy - sight.origin.x(), c * dy - s * dx - sight.origin.y(),
          sight.landmark.z() - sight.origin.z()};
}

double sight_error(const Sight& sight, const Pose2& pose) {
  const Eigen::Vector3d line = line_of_sight(sight, pose);
  const double along = line.dot(sight.ray);
  if (along <= 0.0) return std::numeric_limits<double>::infinity();
  return line.cross(sight.ray).norm() / along;
}

std::optional<Pose2> pose_from_two_sights(const Sight& a, const Sight& b) {
  // rows: by_heading (c, s) + by_offset (x, y) = known, where the landmark is at R(-theta) p + (x, y) in base_link.
  Eigen::Matrix<double, 4, 2> by_heading, by_offset;
  Eigen::Vector4d known;
  int row = 0;
  for (const Sight* sight : {&a, &b}) {
    const Eigen::Vector3d& p = sight->landmark;
    for (const Eigen::Vector3d& e : across(sight->ray)) {
      by_heading.row(row) << e.x() * p.x() + e.y() * p.y(), e.x() * p.y() - e.y() * p.x();
      by_offset.row(row) << e.x(), e.y();
      known[row++] = e.dot(sight->origin) - e.z() * p.z();
    }
  }
  const Eigen::Matrix2d normal = by_offset.transpose() * by_offset;
  if (!(normal.determinant() > 1e-6)) return std::nullopt;
  const Eigen::Matrix<double, 2, 4> to_offset = normal.inverse() * by_offset.transpose();
  const Eigen::Matrix<double, 4, 2> m = by_heading - by_offset * (to_offset * by_heading);
  const Eigen::Vector4d k = known - by_offset * (to_offset * known);
  // |m u - k|^2 over unit vectors u, by its 2 x 2 normal equations.
  const Eigen::Matrix2d q = m.transpose() * m;
  const Eigen::Vector2d l = m.transpose() * k;
  const auto cost = [&](double theta) {
    const Eigen::Vector2d u(std::cos(theta), std::sin(theta));
    return u.dot(q * u) - 2.0 * l.dot(u);
  };
  std::array<double, kHeadings> costs{};
  for (int i = 0; i < kHeadings; ++i) costs[static_cast<std::size_t>(i)] = cost(kHeadingStep * i);
  std::optional<Pose2> best;
  double least = kLargestMiss;
  for (int i = 0; i < kHeadings; ++i) {
    const auto at = [&](int heading) { return costs[static_cast<std::size_t>((heading + kHeadings) % kHeadings)]; };
    if (at(i) > at(i - 1) || at(i) > at(i + 1)) continue;
    double theta = kHeadingStep * i;
    for (int step = 0; step < kNewtonSteps; ++step) {
      const Eigen::Vector2d u(std::cos(theta), std::sin(theta)), turned(-u.y(), u.x());
      const double slope = turned.dot(q * u - l);
      const double curvature = turned.dot(q * turned) - u.dot(q * u - l);
      if (!(curvature > 0.0)) break;
      theta -= slope / curvature;
    }
    const Eigen::Vector2d u(std::cos(theta), std::sin(theta));
    const Eigen::Vector2d offset = to_offset * (known - by_heading * u);
    // offset = -R(-theta) o
    const Pose2 pose{-(u.x() * offset.x() - u.y() * offset.y()), -(u.y() * offset.x() + u.x() * offset.y()),
                     common::normalize_angle(theta)};
    const double miss = std::max(sight_error(a, pose), sight_error(b, pose));
    if (miss < least) {
      least = miss;
      best = pose;
    }
  }
  return best;
}

std::optional<RefinedPose> refine_pose(std::span<const Sight> sights, const Pose2& start, double sigma) {
  Pose2 pose = start;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (int step = 0; step < kRefinements; ++step) {
    information.setZero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    const double c = std::cos(pose.theta), s = std::sin(pose.theta);
    for (const Sight& sight : sights) {
      const Eigen::Vector3d line = line_of_sight(sight, pose);
      const double distance = line.norm();
      if (!(line.dot(sight.ray) > 0.0)) continue;
      Eigen::Matrix3d by_pose = Eigen::Matrix3d::Zero();  // d line / d (x, y, theta)
      by_pose.col(0) << -c, s, 0.0;
      by_pose.col(1) << -s, -c, 0.0;
      by_pose.col(2) << line.y() + sight.origin.y(), -(line.x() + sight.origin.x()), 0.0;
      const double weight = 1.0 / (sigma * sigma * distance * distance + sight.landmark_variance);
      for (const Eigen::Vector3d& e : across(sight.ray)) {
        const Eigen::Vector3d row = by_pose.transpose() * e;
        information += weight * row * row.transpose();
        gradient += weight * row * e.dot(line);
      }
    }
    const Eigen::LLT<Eigen::Matrix3d> llt(information);
    if (llt.info() != Eigen::Success) return std::nullopt;
    const Eigen::Vector3d change = llt.solve(-gradient);
    if (!change.allFinite()) return std::nullopt;
    pose = {pose.x + change.x(), pose.y + change.y(), common::normalize_angle(pose.theta + change.z())};
    if (change.norm() < kConverged) break;
  }
  return RefinedPose{pose, information.inverse()};
}

}  // namespace slamfuse::visual_slam
