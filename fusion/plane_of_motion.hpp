// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "common/trajectory.hpp"
#include "fusion/alignment.hpp"

namespace slamfuse::fusion {

/// The plane a robot drove in, found in a trajectory whose axes may point anywhere (a monocular SLAM counts in the
/// frame of its first camera: x right, y down, z forward).
struct PlaneOfMotion {
  Eigen::Vector3d x = Eigen::Vector3d::UnitX();       ///< the plane's x axis in the trajectory's frame, unit length
  Eigen::Vector3d y = Eigen::Vector3d::UnitY();       ///< its y axis
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< up: x cross y
  int heading_axis = 0;  ///< which axis of the body frame gives the heading (0 x, 1 y, 2 z): one that lies in the plane
  double flatness = 0.0;  ///< standard deviation of the positions off the plane over that along its narrow direction
};

/// Finds the plane by principal components of the positions. Which side is up follows from the body axis that stays
/// closest to the normal: its z axis points up (base_link), its y axis down (optical frames), its x axis up. A
/// trajectory that is planar already (no height, no tilt) gives exactly the x-y plane. Returns nothing for fewer than
/// three poses, a pose that is not finite, or positions on a line, which do not fix a plane.
std::optional<PlaneOfMotion> find_plane_of_motion(const common::Trajectory3& trajectory);

/// The same plane seen from below.
PlaneOfMotion turned_over(const PlaneOfMotion& plane);

/// The trajectory projected into the plane; the origin stays the origin.
common::Trajectory2 project(const common::Trajectory3& trajectory, const PlaneOfMotion& plane);

/// Two trajectories in space, in their planes of motion, aligned.
struct SpatialAlignment {
  Alignment alignment;
  common::Trajectory2 laser;   ///< in its plane; what alignment maps to
  common::Trajectory2 visual;  ///< in its plane; what alignment maps from
};

/// Aligns two trajectories in space, e.g. of any two SLAM systems. Each is brought into its plane of motion first; of
/// the visual plane both sides are tried, since nothing but the laser's turning sense tells for sure which one is up,
/// and the one with the smaller held-out error stays. Refused, with the reason, where no plane is found.
SpatialAlignment align_spatial(const common::Trajectory3& laser, const common::Trajectory3& visual,
                               const AlignmentOptions& options);

}  // namespace slamfuse::fusion
