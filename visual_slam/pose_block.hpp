// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "common/pose3.hpp"
#include "visual_slam/body_pose.hpp"
#include "visual_slam/state.hpp"

namespace slamfuse::visual_slam {

/// Between pose blocks of the state, planar (kPose) or free (kFreePose), and what computes with poses: the only place
/// that asks which of the two a block is, besides State.

/// The seven numbers of a kFreePose.
Eigen::VectorXd free_pose_mean(const common::Pose3& pose);
common::Pose3 free_pose(const Eigen::VectorXd& mean);

BodyPose body_pose(const State& state, BlockId block);
common::Pose3 spatial_pose(const State& state, BlockId block);
/// Position and yaw; height, pitch and roll are dropped.
common::Pose2 planar_pose(const State& state, BlockId block);
/// Covariance of planar_pose in (x, y, theta).
Eigen::Matrix3d planar_covariance(const State& state, BlockId block);
/// Puts a pose where planar_pose is `pose` with that covariance, independent of everything else. A free one keeps
/// height, pitch and roll.
void set_planar_pose(State& state, BlockId block, const common::Pose2& pose, const Eigen::Matrix3d& covariance);

/// Enters a copy of a pose: the past pose it will have been.
BlockId append_copy(State& state, BlockId block);

/// The pose of one block in another's, and its covariance by its six numbers, see BodyPose, in the axes of `from`.
struct RelativeMotion {
  BodyPose motion;
  Eigen::Matrix<double, 6, 6> covariance;
};
RelativeMotion relative_motion(const State& state, BlockId from, BlockId to);

/// A derivative by the six numbers of a pose, see BodyPose, as the part for a pose block.
template <int Rows>
JacobianPart<Rows> pose_part(const State& state, BlockId block, const Eigen::Matrix<double, Rows, 6>& wrt_pose) {
  if (state.kind(block) == BlockKind::kFreePose) return {block, wrt_pose};
  Eigen::Matrix<double, Rows, 3> planar;
  planar << wrt_pose.template leftCols<2>(), wrt_pose.template rightCols<1>();
  return {block, planar};
}

}  // namespace slamfuse::visual_slam
