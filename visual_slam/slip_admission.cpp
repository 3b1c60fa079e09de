// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/slip_admission.hpp"

#include <span>

#include <Eigen/QR>

namespace slamfuse::visual_slam {

void SlipAdmission::begin(State& state, BlockId robot, BlockId parameters, const Slip& by_slip) {
  mean_ = state.mean(parameters);
  covariance_ = state.covariance(parameters, parameters);
  const BlockId slip = state.append(Eigen::Vector2d::Zero(), BlockKind::kCalibration, {}, Eigen::Matrix2d::Identity());
  const int count = static_cast<int>(mean_.size());
  const JacobianPart<Eigen::Dynamic> to_parameters[] = {{parameters, Eigen::MatrixXd::Identity(count, count)},
                                                        {slip, by_slip.parameters}};
  state.transform(parameters, mean_, BlockKind::kCalibration, to_parameters, Eigen::MatrixXd::Zero(count, count));
  const JacobianPart<Eigen::Dynamic> to_pose[] = {{robot, Eigen::Matrix3d::Identity()}, {slip, by_slip.pose}};
  state.transform(robot, Eigen::VectorXd(state.mean(robot)), BlockKind::kPose, to_pose, Eigen::Matrix3d::Zero());
  state.remove(std::span(&slip, 1));
}

void SlipAdmission::end(State& state, BlockId robot, BlockId parameters, const Slip& by_slip) const {
  const Eigen::MatrixXd to_pose = by_slip.pose * by_slip.parameters.colPivHouseholderQr().solve(
                                                     Eigen::MatrixXd::Identity(mean_.size(), mean_.size()));
  const Eigen::Vector3d change = to_pose * (mean_ - state.mean(parameters));
  const Eigen::Matrix3d noise = to_pose * state.covariance(parameters, parameters) * to_pose.transpose();
  const JacobianPart<Eigen::Dynamic> same[] = {{robot, Eigen::Matrix3d::Identity()}};
  state.transform(robot, Eigen::VectorXd(state.mean(robot) + change), BlockKind::kPose, same, noise);
  state.transform(parameters, mean_, BlockKind::kCalibration, {}, covariance_);
}

}  // namespace slamfuse::visual_slam
