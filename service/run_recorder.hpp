// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "common/pose_estimate.hpp"
#include "common/trajectory.hpp"
#include "fusion/status.hpp"
#include "service/pipeline_observer.hpp"

namespace slamfuse::service {

/// Everything a run told, in order.
struct RunLog {
  /// Poses as they were known at their moment, by source; none while LOST.
  std::map<common::PoseSource, common::Trajectory2> trajectories;
  /// Every estimate of laser, visual and fused, LOST ones too.
  std::map<common::PoseSource, std::vector<common::PoseEstimate>> estimates;
  std::vector<fusion::StatusEntry> status;
  std::vector<common::Event> events;
};

/// Keeps what the output files are made from.
class RunRecorder : public PipelineObserver {
 public:
  void on_odometry(const common::WheelOdometry& odometry) override;
  void on_estimate(const common::PoseEstimate& estimate) override;
  void on_corrected_pose(const fusion::CorrectedPose& pose) override;
  void on_status(const fusion::StatusEntry& status) override { log_.status.push_back(status); }
  void on_event(const common::Event& event) override { log_.events.push_back(event); }

  const RunLog& log() const { return log_; }

 private:
  RunLog log_;
};

}  // namespace slamfuse::service
