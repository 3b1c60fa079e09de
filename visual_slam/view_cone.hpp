// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "visual_slam/camera.hpp"

namespace slamfuse::visual_slam {

/// The cone about a camera's optical axis that holds all it can see: tells at little cost which of many points are not
/// worth projecting.
class ViewCone {
 public:
  /// `centre` and `axis` (of length 1) are the camera's in the frame of the points.
  ViewCone(const Camera& camera, const Eigen::Vector3d& centre, const Eigen::Vector3d& axis);

  /// False only of points that are not in the picture.
  bool may_show(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d view = point - centre_;
    const double depth = view.dot(axis_);
    return depth > 0.0 && view.squaredNorm() <= widest_ * depth * depth;
  }

 private:
  Eigen::Vector3d centre_;
  Eigen::Vector3d axis_;
  double widest_;  // the square of a ray over that of its depth
};

}  // namespace slamfuse::visual_slam
