// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "common/pose2.hpp"

namespace slamfuse::visual_slam {

/// A landmark of known place seen in a known direction from base_link: a camera's pixel with its mounting undone, so
/// that sights of several cameras, and by the odometry of several images, can be taken together.
struct Sight {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();    ///< the camera's optical centre in base_link
  Eigen::Vector3d ray = Eigen::Vector3d::UnitX();      ///< unit vector from there, in base_link
  Eigen::Vector3d landmark = Eigen::Vector3d::Zero();  ///< in the map
  double landmark_variance = 0.0;                      ///< of each coordinate
};

/// The vector from the optical centre to the landmark, in base_link at `pose`.
Eigen::Vector3d line_of_sight(const Sight& sight, const common::Pose2& pose);

/// Tangent of the angle between where the landmark is from `pose` and where it was seen; infinite when it is behind.
double sight_error(const Sight& sight, const common::Pose2& pose);

/// The pose from which two landmarks appear where they were seen: four equations for three unknowns. Seen from the
/// planar pose (x, y, theta), a sight says e_i . (R(-theta) (p - o) - t) = 0 for two unit vectors across its ray; that
/// is linear in (cos theta, sin theta) and the unknown offset, which is eliminated. The remaining least squares over
/// the unit circle have up to two minima, among them poses that would have a landmark behind; each is solved by
/// Newton's method from evenly spaced headings, and the one whose sights miss least is taken. Empty when the sights
/// contradict each other (they miss by more than a tenth of their distance) or a landmark would be behind. Not in the
/// seeds.
std::optional<common::Pose2> pose_from_two_sights(const Sight& a, const Sight& b);

/// A pose and how well it is known.
struct RefinedPose {
  common::Pose2 pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of (x, y, theta) in the map
};

/// The pose at which all sights fit best: iterated least squares on the two components across each ray, each weighted
/// by the angular noise `sigma` [rad] and the landmark's own. The covariance takes these errors for independent. Empty
/// when the sights do not determine the pose.
std::optional<RefinedPose> refine_pose(std::span<const Sight> sights, const common::Pose2& start, double sigma);

}  // namespace slamfuse::visual_slam
