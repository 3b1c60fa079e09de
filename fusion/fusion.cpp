// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/fusion.hpp"

#include "common/odometry_buffer.hpp"

namespace slamfuse::fusion {

struct Fusion::State {
  FusionOptions options;
  common::OdometryBuffer odometry;
  std::optional<common::PoseEstimate> newest;
  common::Pose2 T_map_odom;
  common::Trajectory2 laser;
  common::Trajectory2 visual;
  common::Trajectory2 fused;
  std::optional<Alignment> alignment;
};

common::Result<std::unique_ptr<Fusion>> Fusion::create(const FusionOptions& options) {
  return std::unique_ptr<Fusion>(new Fusion(options));
}

Fusion::Fusion(const FusionOptions& options) : state_(std::make_unique<State>()) { state_->options = options; }
Fusion::~Fusion() = default;

FusionOutput Fusion::process(const common::WheelOdometry& odometry) {
  FusionOutput output;
  state_->odometry.add(odometry);
  if (!state_->newest) return output;
  CorrectedPose pose;
  pose.estimate = *state_->newest;
  pose.estimate.source = common::PoseSource::kFused;
  pose.estimate.stamp = odometry.stamp;
  pose.estimate.pose = state_->T_map_odom * odometry.pose;
  pose.T_map_odom = state_->T_map_odom;
  state_->fused.push_back({odometry.stamp, pose.estimate.pose});
  output.pose = pose;
  return output;
}

FusionOutput Fusion::process(const common::PoseEstimate& estimate) {
  FusionOutput output;
  if (estimate.source == common::PoseSource::kVisual) {
    state_->visual.push_back({estimate.stamp, estimate.pose});
    return output;
  }
  state_->laser.push_back({estimate.stamp, estimate.pose});
  state_->newest = estimate;
  const auto T_odom_base = state_->odometry.pose_at(estimate.stamp);
  state_->T_map_odom = T_odom_base ? estimate.pose * T_odom_base->inverse() : estimate.pose;
  CorrectedPose pose;
  pose.estimate = estimate;
  pose.estimate.source = common::PoseSource::kFused;
  pose.T_map_odom = state_->T_map_odom;
  state_->fused.push_back({estimate.stamp, estimate.pose});
  output.pose = pose;
  return output;
}

FusionOutput Fusion::align_now() {
  state_->alignment = align_trajectories(state_->laser, state_->visual, state_->options.alignment);
  return {};
}

FusionResult Fusion::finish(const common::Trajectory2& laser_final, const common::Trajectory2& visual_final) {
  FusionResult result;
  result.alignment = align_trajectories(laser_final, visual_final, state_->options.alignment);
  result.fused_final = laser_final;
  state_->alignment = result.alignment;
  return result;
}

const std::optional<Alignment>& Fusion::alignment() const { return state_->alignment; }
common::PoseSource Fusion::map_frame() const { return common::PoseSource::kLaser; }

}  // namespace slamfuse::fusion
