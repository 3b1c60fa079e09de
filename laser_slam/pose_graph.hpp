// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"

namespace slamfuse::laser_slam {

/// A measured pose of one variable in the frame of another.
struct PoseConstraint {
  int from = 0;                                           ///< index of a variable
  int to = 0;                                             ///< the same
  common::Pose2 measured;                                 ///< T_from_to
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of (x, y, theta) in the frame of `from`; may be singular
  bool loop = false;                                      ///< may be wrong altogether: gets a robust loss
};

/// The poses that satisfy the constraints best, from `initial`: minimises the sum of the squared errors e' I e with
/// e = (R_from' (t_to - t_from) - t_measured, theta_to - theta_from - theta_measured), that of loops under Cauchy's
/// loss of scale `loop_outlier` (Konolige et al. 2010, Efficient Sparse Pose Adjustment; Levenberg-Marquardt by Ceres).
/// The first pose stays where it is. The indices of the constraints must be those of `initial`. Gives `initial` back
/// when there is nothing to solve or no solution.
std::vector<common::Pose2> optimise_poses(const std::vector<common::Pose2>& initial,
                                          const std::vector<PoseConstraint>& constraints, double loop_outlier);

}  // namespace slamfuse::laser_slam
