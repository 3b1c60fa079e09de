// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/pose_block.hpp"

#include "common/angle.hpp"

namespace slamfuse::visual_slam {
namespace {

bool is_free(const State& state, BlockId block) { return state.kind(block) == BlockKind::kFreePose; }

/// (x, y, theta) of a free pose by its six numbers.
Eigen::Matrix<double, 3, 6> planar_by_free(const common::Pose3& pose) {
  const Eigen::Vector3d forward = pose.rotation * Eigen::Vector3d::UnitX();
  Eigen::Matrix<double, 3, 6> jacobian = Eigen::Matrix<double, 3, 6>::Zero();
  jacobian(0, 0) = jacobian(1, 1) = 1.0;
  jacobian.block<1, 2>(2, 3) = -forward.z() / forward.head<2>().squaredNorm() * forward.head<2>().transpose();
  jacobian(2, 5) = 1.0;
  return jacobian;
}

}  // namespace

Eigen::VectorXd free_pose_mean(const common::Pose3& pose) {
  Eigen::VectorXd mean(7);
  mean << pose.translation, pose.rotation.coeffs();
  return mean;
}

common::Pose3 free_pose(const Eigen::VectorXd& mean) {
  return {mean.head<3>(), Eigen::Quaterniond(Eigen::Vector4d(mean.tail<4>()))};
}

BodyPose body_pose(const State& state, BlockId block) {
  return is_free(state, block) ? BodyPose(spatial_pose(state, block)) : BodyPose(planar_pose(state, block));
}

common::Pose3 spatial_pose(const State& state, BlockId block) {
  return is_free(state, block) ? free_pose(state.mean(block)) : common::to_pose3(planar_pose(state, block));
}

common::Pose2 planar_pose(const State& state, BlockId block) {
  if (is_free(state, block)) return common::to_pose2(spatial_pose(state, block));
  const Eigen::Vector3d numbers = state.mean(block);
  return {numbers.x(), numbers.y(), common::normalize_angle(numbers.z())};
}

Eigen::Matrix3d planar_covariance(const State& state, BlockId block) {
  if (!is_free(state, block)) return state.covariance(block, block);
  const Eigen::Matrix<double, 3, 6> jacobian = planar_by_free(spatial_pose(state, block));
  return jacobian * state.covariance(block, block) * jacobian.transpose();
}

BlockId append_copy(State& state, BlockId block) {
  const Eigen::Index size = state.covariance(block, block).rows();
  const JacobianPart<Eigen::Dynamic> copy[] = {{block, Eigen::MatrixXd::Identity(size, size)}};
  return state.append(state.mean(block), state.kind(block), copy, Eigen::MatrixXd::Zero(size, size));
}

RelativeMotion relative_motion(const State& state, BlockId from, BlockId to) {
  const BodyPose here = body_pose(state, from), there = body_pose(state, to);
  const Eigen::Matrix3d to_here = here.rotation.transpose();
  Eigen::Matrix<double, 6, 6> by_there = Eigen::Matrix<double, 6, 6>::Zero();
  by_there.topLeftCorner<3, 3>() = by_there.bottomRightCorner<3, 3>() = to_here;
  Eigen::Matrix<double, 6, 6> by_here = -by_there;
  by_here.topRightCorner<3, 3>() = to_here * cross_matrix(there.position - here.position);
  const JacobianPart<6> parts[] = {pose_part(state, from, by_here), pose_part(state, to, by_there)};
  RelativeMotion result{here.inverse() * there, Eigen::Matrix<double, 6, 6>::Zero()};
  for (const auto& row : parts) {
    for (const auto& column : parts) {
      result.covariance += row.matrix * state.covariance(row.block, column.block) * column.matrix.transpose();
    }
  }
  return result;
}

void set_planar_pose(State& state, BlockId block, const common::Pose2& pose, const Eigen::Matrix3d& covariance) {
  if (!is_free(state, block)) {
    state.transform(block, pose.vector(), BlockKind::kPose, {}, covariance);
    return;
  }
  const common::Pose3 old = spatial_pose(state, block);
  const double turn = pose.theta - common::to_pose2(old).theta;
  const Eigen::Quaterniond about_z(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
  const common::Pose3 moved{{pose.x, pose.y, old.translation.z()}, (about_z * old.rotation).normalized()};
  Eigen::MatrixXd kept = Eigen::MatrixXd::Zero(6, 6);
  kept(2, 2) = 1.0;
  kept.block<2, 2>(3, 3) = about_z.toRotationMatrix().topLeftCorner<2, 2>();
  // The yaw's error is made independent of pitch and roll by taking the part they have in it out of the third turn.
  kept.block<1, 2>(5, 3) = -planar_by_free(moved).block<1, 2>(2, 3) * kept.block<2, 2>(3, 3);
  Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(6, 6);
  for (const int row : {0, 1, 2}) {
    for (const int column : {0, 1, 2}) noise(row == 2 ? 5 : row, column == 2 ? 5 : column) = covariance(row, column);
  }
  const JacobianPart<Eigen::Dynamic> self[] = {{block, kept}};
  state.transform(block, free_pose_mean(moved), BlockKind::kFreePose, self, noise);
}

}  // namespace slamfuse::visual_slam
