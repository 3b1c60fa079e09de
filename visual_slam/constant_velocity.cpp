// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/constant_velocity.hpp"

#include <cmath>

#include "common/angle.hpp"

namespace slamfuse::visual_slam {
namespace {

double square(double value) { return value * value; }

}  // namespace

BlockId ConstantVelocity::append_parameters(State& state) const {
  const Eigen::Vector4d variances(square(options_.unit_sigma), square(options_.initial_speed_sigma),
                                  square(common::to_radians(options_.initial_turn_rate_sigma)),
                                  square(options_.lever_scale_sigma));
  return state.append(Eigen::VectorXd::Zero(kSize), BlockKind::kVelocity, {}, variances.asDiagonal());
}

bool ConstantVelocity::predict(State& state, BlockId robot, BlockId parameters, const MotionStep& step) const {
  const double dt = step.seconds;
  if (dt <= 0.0) return false;
  const Eigen::Vector4d change(0.0, square(step.speed_is_told ? options_.told_speed_noise : options_.speed_noise) * dt,
                               square(common::to_radians(options_.turn_rate_noise)) * dt, 0.0);
  const JacobianPart<Eigen::Dynamic> same[] = {{parameters, Eigen::Matrix4d::Identity()}};
  state.transform(parameters, Eigen::VectorXd(state.mean(parameters)), BlockKind::kVelocity, same, change.asDiagonal());

  const Eigen::Vector3d way =
      dt * Eigen::Vector3d(state.mean(parameters)[kSpeed], 0.0, state.mean(parameters)[kTurnRate]);
  const common::Pose2 pose{state.mean(robot)[0], state.mean(robot)[1], state.mean(robot)[2]};
  const common::Pose2 increment = common::exp_se2(way);
  const common::ComposeJacobians compose = common::compose_jacobians(pose, increment);
  const Eigen::Matrix3d by_way = compose.wrt_b * exp_se2_jacobian(way);
  Eigen::MatrixXd by_parameters = Eigen::MatrixXd::Zero(3, kSize);
  by_parameters.col(kSpeed) = dt * by_way.col(0);
  by_parameters.col(kTurnRate) = dt * by_way.col(2);
  const JacobianPart<Eigen::Dynamic> parts[] = {{robot, compose.wrt_a}, {parameters, by_parameters}};
  const double slip = square(options_.lateral_noise) * std::abs(way.x());
  state.transform(robot, (pose * increment).vector(), BlockKind::kPose, parts,
                  slip * by_way.col(1) * by_way.col(1).transpose());
  return true;
}

double ConstantVelocity::lever_scale(const State& state, BlockId parameters) const {
  return std::exp(state.mean(parameters)[kLeverScale]);
}

std::optional<MotionNumber> ConstantVelocity::metric_speed(const State& state, BlockId parameters) const {
  const double metres = std::exp(-state.mean(parameters)[kLeverScale]);
  MotionNumber speed{state.mean(parameters)[kSpeed] * metres, Eigen::RowVectorXd::Zero(kSize)};
  speed.wrt_parameters[kSpeed] = metres;
  speed.wrt_parameters[kLeverScale] = -speed.value;
  return speed;
}

std::optional<BodyTwist> ConstantVelocity::twist(const State& state, BlockId parameters) const {
  return BodyTwist({state.mean(parameters)[kSpeed], 0.0, 0.0}, {0.0, 0.0, state.mean(parameters)[kTurnRate]});
}

}  // namespace slamfuse::visual_slam
