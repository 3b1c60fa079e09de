// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/free_camera.hpp"

#include <cmath>

#include "common/angle.hpp"
#include "visual_slam/pose_block.hpp"

namespace slamfuse::visual_slam {
namespace {

using Numbers = Eigen::Matrix<double, 8, 1>;

double square(double value) { return value * value; }

}  // namespace

BlockId FreeCamera::append_robot(State& state) const {
  return state.append(free_pose_mean({}), BlockKind::kFreePose, {},
                      square(kFirstPoseSigma) * Eigen::Matrix<double, 6, 6>::Identity());
}

BlockId FreeCamera::append_parameters(State& state) const {
  Numbers variances;
  variances << square(options_.unit_sigma), Eigen::Vector3d::Constant(square(options_.initial_speed_sigma)),
      Eigen::Vector3d::Constant(square(common::to_radians(options_.initial_turn_rate_sigma))),
      square(options_.lever_scale_sigma);
  return state.append(Numbers::Zero(), BlockKind::kFreeVelocity, {}, variances.asDiagonal().toDenseMatrix());
}

bool FreeCamera::predict(State& state, BlockId robot, BlockId parameters, const MotionStep& step) const {
  const double dt = step.seconds;
  if (dt <= 0.0) return false;
  Numbers change = Numbers::Zero();
  change.segment<3>(kVelocity).setConstant(square(options_.speed_noise) * dt);
  change.segment<3>(kTurnRate).setConstant(square(common::to_radians(options_.turn_rate_noise)) * dt);
  const JacobianPart<Eigen::Dynamic> same[] = {{parameters, Eigen::MatrixXd::Identity(kSize, kSize)}};
  state.transform(parameters, Eigen::VectorXd(state.mean(parameters)), BlockKind::kFreeVelocity, same,
                  change.asDiagonal().toDenseMatrix());

  const common::Pose3 pose = free_pose(state.mean(robot));
  const BodyTwist moving = *twist(state, parameters);
  const Eigen::Vector3d turn = dt * moving.angular;
  // The way is the chord of the arc: it points where base_link points half-way.
  const Eigen::Matrix3d half_way = (pose.rotation * rotation_exp(0.5 * turn)).toRotationMatrix();
  const Eigen::Vector3d way = dt * (half_way * moving.linear);
  const Eigen::Matrix3d turned_by_rate = dt * pose.rotation.toRotationMatrix() * rotation_left_jacobian(turn);
  const Eigen::Matrix3d half_by_rate = 0.5 * dt * pose.rotation.toRotationMatrix() * rotation_left_jacobian(0.5 * turn);

  Eigen::MatrixXd by_pose = Eigen::MatrixXd::Identity(6, 6);
  by_pose.topRightCorner<3, 3>() = -cross_matrix(way);
  Eigen::MatrixXd by_parameters = Eigen::MatrixXd::Zero(6, kSize);
  by_parameters.block<3, 3>(0, kVelocity) = dt * half_way;
  by_parameters.block<3, 3>(0, kTurnRate) = -cross_matrix(way) * half_by_rate;
  by_parameters.block<3, 3>(3, kTurnRate) = turned_by_rate;
  const JacobianPart<Eigen::Dynamic> parts[] = {{robot, by_pose}, {parameters, by_parameters}};
  const common::Pose3 moved{pose.translation + way, (pose.rotation * rotation_exp(turn)).normalized()};
  state.transform(robot, free_pose_mean(moved), BlockKind::kFreePose, parts, Eigen::MatrixXd::Zero(6, 6));
  return true;
}

double FreeCamera::lever_scale(const State& state, BlockId parameters) const {
  return std::exp(state.mean(parameters)[kLeverScale]);
}

std::optional<BodyTwist> FreeCamera::twist(const State& state, BlockId parameters) const {
  return BodyTwist(state.mean(parameters).segment<3>(kVelocity), state.mean(parameters).segment<3>(kTurnRate));
}

}  // namespace slamfuse::visual_slam
