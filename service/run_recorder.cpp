// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_recorder.hpp"

namespace slamfuse::service {

void RunRecorder::on_odometry(const common::WheelOdometry& odometry) {
  log_.trajectories[common::PoseSource::kOdometry].push_back({odometry.stamp, odometry.pose});
}

void RunRecorder::on_estimate(const common::PoseEstimate& estimate) {
  log_.estimates[estimate.source].push_back(estimate);
  if (estimate.state == common::TrackingState::kLost) return;
  log_.trajectories[estimate.source].push_back({estimate.stamp, estimate.pose});
}

void RunRecorder::on_corrected_pose(const fusion::CorrectedPose& pose) { on_estimate(pose.estimate); }

}  // namespace slamfuse::service
