// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "fusion/planar_affine.hpp"

namespace slamfuse::fusion {

/// The factors of eq. 7 of seed 004, 4x4 each, visual map frame on the right, laser map frame on the left:
///
///     G_LV = T_traj_laser^-1 R_laser^-1 T_curv_laser^-1 T_ess T_curv_visual R_visual T_traj_visual
///
/// The paper prints T_traj where T_curv belongs; T_curv it is. The direct estimators have one factor only, which stands
/// in T_ess.
struct MappingMatrix {
  Eigen::Matrix4d T_traj_laser = Eigen::Matrix4d::Identity();   ///< laser map [m] to its image [px]
  Eigen::Matrix4d R_laser = Eigen::Matrix4d::Identity();        ///< eq. 2 at alpha_L
  Eigen::Matrix4d T_curv_laser = Eigen::Matrix4d::Identity();   ///< rescaling of the rotated, filtered image
  Eigen::Matrix4d T_ess = Eigen::Matrix4d::Identity();          ///< eq. 6
  Eigen::Matrix4d T_curv_visual = Eigen::Matrix4d::Identity();  ///< rescaling of the rotated, filtered image
  Eigen::Matrix4d R_visual = Eigen::Matrix4d::Identity();       ///< eq. 2 at alpha_V
  Eigen::Matrix4d T_traj_visual = Eigen::Matrix4d::Identity();  ///< visual map to its image [px]

  /// G_LV, the product above. Acts on (x, y, 0, 1).
  Eigen::Matrix4d product() const;
  /// What G_LV does to points of the plane z = 0: its rows and columns x, y and the translation.
  PlanarAffine planar() const;
};

/// The mapping matrix of a direct estimator.
MappingMatrix to_mapping_matrix(const PlanarAffine& map);

}  // namespace slamfuse::fusion
