// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/plane_of_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace slamfuse::fusion {
namespace {

/// Heights [m] and tilts [part of 1] below this are rounding of a planar trajectory.
constexpr double kRounding = 1e-6;
/// Positions whose second spread is below this part of the first are on a line.
constexpr double kLine = 1e-4;

bool is_planar(const common::Trajectory3& trajectory) {
  return std::all_of(trajectory.begin(), trajectory.end(), [&](const common::StampedPose3& pose) {
    const double height = pose.pose.translation.z() - trajectory.front().pose.translation.z();
    return std::abs(height) < kRounding && (pose.pose.rotation * Eigen::Vector3d::UnitZ()).z() > 1.0 - kRounding;
  });
}

/// The body axis that keeps closest to `normal`, and its mean component along it.
std::pair<int, double> upright_axis(const common::Trajectory3& trajectory, const Eigen::Vector3d& normal) {
  Eigen::Vector3d components = Eigen::Vector3d::Zero();
  for (const common::StampedPose3& pose : trajectory) components += pose.pose.rotation.inverse() * normal;
  components /= static_cast<double>(trajectory.size());
  int axis = 0;
  components.cwiseAbs().maxCoeff(&axis);
  return {axis, components[axis]};
}

/// Completes the plane from its normal: x is the trajectory frame's axis nearest to the plane (its x where that is not
/// upright), projected.
void complete_axes(PlaneOfMotion& plane) {
  constexpr double kUpright = 0.9;
  const Eigen::Vector3d towards =
      std::abs(plane.normal.x()) < kUpright ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  plane.x = (towards - plane.normal * plane.normal.dot(towards)).normalized();
  plane.y = plane.normal.cross(plane.x);
}

}  // namespace

std::optional<PlaneOfMotion> find_plane_of_motion(const common::Trajectory3& trajectory) {
  if (trajectory.size() < 3) return std::nullopt;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const common::StampedPose3& pose : trajectory) {
    if (!pose.pose.is_finite()) return std::nullopt;
    mean += pose.pose.translation / static_cast<double>(trajectory.size());
  }
  if (is_planar(trajectory)) return PlaneOfMotion{};

  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (const common::StampedPose3& pose : trajectory) {
    const Eigen::Vector3d offset = pose.pose.translation - mean;
    moments += offset * offset.transpose() / static_cast<double>(trajectory.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments);
  const Eigen::Vector3d spread = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  if (spread[1] <= kLine * spread[2]) return std::nullopt;

  PlaneOfMotion plane;
  plane.normal = solver.eigenvectors().col(0);
  plane.flatness = spread[0] / spread[1];
  const auto [axis, component] = upright_axis(trajectory, plane.normal);
  const bool axis_points_down = axis == 1;  // an optical frame's y
  if ((component > 0.0) == axis_points_down) plane.normal = -plane.normal;
  plane.heading_axis = (axis + 1) % 3;
  complete_axes(plane);
  return plane;
}

PlaneOfMotion turned_over(const PlaneOfMotion& plane) {
  PlaneOfMotion other = plane;
  other.normal = -plane.normal;
  other.y = -plane.y;
  return other;
}

common::Trajectory2 project(const common::Trajectory3& trajectory, const PlaneOfMotion& plane) {
  common::Trajectory2 planar;
  planar.reserve(trajectory.size());
  for (const common::StampedPose3& pose : trajectory) {
    const Eigen::Vector3d heading = pose.pose.rotation * Eigen::Vector3d::Unit(plane.heading_axis);
    planar.push_back({pose.stamp,
                      {plane.x.dot(pose.pose.translation), plane.y.dot(pose.pose.translation),
                       std::atan2(plane.y.dot(heading), plane.x.dot(heading))}});
  }
  return planar;
}

SpatialAlignment align_spatial(const common::Trajectory3& laser, const common::Trajectory3& visual,
                               const AlignmentOptions& options) {
  const auto laser_plane = find_plane_of_motion(laser);
  const auto visual_plane = find_plane_of_motion(visual);
  if (!laser_plane || !visual_plane) {
    SpatialAlignment refused;
    refused.alignment.method = options.method;
    refused.alignment.reason = std::string("the ") + (laser_plane ? "visual" : "laser") +
                               " trajectory has no plane of motion: it has fewer than three poses, a pose that is not "
                               "finite, or is straight";
    return refused;
  }
  SpatialAlignment best;
  best.laser = project(laser, *laser_plane);
  best.visual = project(visual, *visual_plane);
  best.alignment = align_trajectories(best.laser, best.visual, options);
  if (is_planar(visual)) return best;

  SpatialAlignment other;
  other.laser = best.laser;
  other.visual = project(visual, turned_over(*visual_plane));
  other.alignment = align_trajectories(other.laser, other.visual, options);
  const auto better = [](const Alignment& a, const Alignment& b) {
    if (a.accepted != b.accepted) return a.accepted;
    return a.heldout_rmse < b.heldout_rmse;
  };
  return better(other.alignment, best.alignment) ? other : best;
}

}  // namespace slamfuse::fusion
