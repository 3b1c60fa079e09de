// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "visual_slam/body_pose.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/projection.hpp"

namespace slamfuse::visual_slam {

/// Two sights of one landmark, seed 000 section II.E: does the pair fix the landmark's place well enough for a
/// Gaussian?
struct ObservationPair {
  const Camera* first_camera = nullptr;
  const Camera* second_camera = nullptr;
  Bearing first;    ///< seen from the earlier pose
  Bearing second;   ///< seen from the later one
  BodyPose motion;  ///< the later pose of base_link in the earlier one [m or the map's unit]
  /// Covariance of `motion` by its six numbers, see BodyPose, in the axes of the earlier pose.
  Eigen::Matrix<double, 6, 6> motion_covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double lever_scale = 1.0;  ///< see project_cartesian
};

/// Where the rays of a pair meet.
struct Intersection {
  double inverse_depth = 0.0;  ///< along the first camera's optical axis [1/m]
  Eigen::Vector2d along;       ///< unit vector in the second image along which the depth shows, the epipolar line
};
/// Empty when the pair has no parallax at all. The inverse depth may be negative: the rays meet behind the camera.
std::optional<Intersection> intersect(const ObservationPair& pair);

/// Kullback-Leibler divergence of the landmark's distribution, sampled, from the Gaussian that linearised intersection
/// would enter into the filter: 0 when the intersection is linear within the noise, infinite when a sample of the noise
/// puts the landmark at infinity or behind the camera. A pair with a small one is well-conditioned.
///
/// The sampled errors s are those of the motion (6), of the first bearing (2) and of the second along the epipolar
/// line. They map to the motion and the landmark's place one to one, so the true density is that of s over the
/// determinant of the map; with 5.5 (sigma_d / d)^2 as the leading term when only the depth d is uncertain. `samples`
/// are taken, always the same ones.
double divergence_from_gaussian(const ObservationPair& pair, const Intersection& at, int samples);

/// The landmark's place in the map by the linearised intersection, with the derivatives the filter needs.
struct PairPoint {
  Eigen::Vector3d position;
  Eigen::Matrix<double, 3, 6> wrt_robot;   ///< the later pose, see BodyPose
  Eigen::Matrix<double, 3, 6> wrt_anchor;  ///< the earlier one
  Eigen::Vector3d wrt_lever_scale;         ///< the logarithm of the lever scale
  Eigen::Matrix3d covariance;              ///< by the noise of the two bearings
};
/// `anchor_pose` is the earlier pose in the map. Empty when the landmark is not in front of both cameras.
std::optional<PairPoint> point_of_pair(const ObservationPair& pair, const Intersection& at,
                                       const BodyPose& anchor_pose);

}  // namespace slamfuse::visual_slam
