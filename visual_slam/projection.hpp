// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "visual_slam/body_pose.hpp"
#include "visual_slam/camera.hpp"

namespace slamfuse::visual_slam {

/// Where and how a landmark was seen first: what its inverse-depth parameters refer to.
struct Anchor {
  const Camera* camera = nullptr;
  BodyPose row_shift;  ///< see Bearing
};

/// A landmark as a camera sees it, with the derivatives the filter needs.
struct Projection {
  Eigen::Vector2d point;                     ///< normalised image point (x/z, y/z)
  Eigen::Matrix<double, 2, 6> wrt_robot;     ///< the pose of base_link, see BodyPose
  Eigen::Matrix<double, 2, 6> wrt_anchor;    ///< the anchor pose; zero for Cartesian landmarks
  Eigen::Matrix<double, 2, 3> wrt_landmark;  ///< its three numbers
  Eigen::Vector2d wrt_lever_scale;           ///< the logarithm of `lever_scale`
};

/// A Cartesian landmark (x, y, z) [m] of the map: seed 000 eq. 1 without the intrinsics (bearings are undistorted).
/// Empty when it is behind the camera. `lever_scale` is how many units of the map a metre of the camera's lever arm is:
/// 1 when the map is in metres.
std::optional<Projection> project_cartesian(const Camera& camera, const BodyPose& row_shift, const BodyPose& robot,
                                            const Eigen::Vector3d& landmark, double lever_scale = 1.0);

/// A landmark by inverse depth: (u, v, rho), the ray (u, v, 1) of the anchor camera and the inverse of the depth along
/// its optical axis [1/m]. Seed 002 section 2.3, except that the anchor is a past robot pose shared by all landmarks
/// seen first in one image instead of three more numbers a landmark, and the ray is (u, v, 1), not azimuth and
/// elevation: the state stays smaller and the parameters do not turn with the map. Empty when behind the camera.
std::optional<Projection> project_anchored(const Camera& camera, const BodyPose& row_shift, const BodyPose& robot,
                                           const Anchor& anchor, const BodyPose& anchor_pose,
                                           const Eigen::Vector3d& landmark, double lever_scale = 1.0);

/// The Cartesian position of an inverse-depth landmark with rho > 0.
struct CartesianPoint {
  Eigen::Vector3d position;
  Eigen::Matrix<double, 3, 6> wrt_anchor;
  Eigen::Matrix3d wrt_landmark;
  Eigen::Vector3d wrt_lever_scale;  ///< the logarithm of `lever_scale`
};
CartesianPoint to_cartesian(const Anchor& anchor, const BodyPose& anchor_pose, const Eigen::Vector3d& landmark,
                            double lever_scale = 1.0);

/// Optical centre of a camera in the map.
Eigen::Vector3d optical_centre(const Camera& camera, const BodyPose& robot, double lever_scale = 1.0);

/// Civera, Davison and Montiel's linearity index (2008, the work behind seed 002): 4 sigma_d / d |cos(parallax)|, where
/// d is the distance from the camera that looks now.
double linearity_index(const Eigen::Vector3d& anchor_centre, const Eigen::Vector3d& camera_centre,
                       const Eigen::Vector3d& point, double rho, double rho_sigma);

}  // namespace slamfuse::visual_slam
