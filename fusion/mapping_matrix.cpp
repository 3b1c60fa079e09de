// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/mapping_matrix.hpp"

#include <Eigen/LU>

namespace slamfuse::fusion {

Eigen::Matrix4d MappingMatrix::product() const {
  return T_traj_laser.inverse() * R_laser.inverse() * T_curv_laser.inverse() * T_ess * T_curv_visual * R_visual *
         T_traj_visual;
}

PlanarAffine MappingMatrix::planar() const {
  const Eigen::Matrix4d g = product();
  return {g.topLeftCorner<2, 2>(), g.topRightCorner<2, 1>()};
}

MappingMatrix to_mapping_matrix(const PlanarAffine& map) {
  MappingMatrix mapping;
  mapping.T_ess.topLeftCorner<2, 2>() = map.linear;
  mapping.T_ess.topRightCorner<2, 1>() = map.translation;
  mapping.T_ess(2, 2) = take_apart(map).mean_scale;
  return mapping;
}

}  // namespace slamfuse::fusion
