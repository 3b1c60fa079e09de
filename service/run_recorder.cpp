// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_recorder.hpp"

#include <algorithm>

#include "common/trajectory_coverage.hpp"

namespace slamfuse::service {

using common::PoseSource;

RunRecorder::RunRecorder(std::size_t most_kept) : most_kept_(most_kept), status_(most_kept) {}

void RunRecorder::on_odometry(const common::WheelOdometry& odometry) {
  series(trajectories_, PoseSource::kOdometry).push({odometry.stamp, odometry.pose});
}

void RunRecorder::on_estimate(const common::PoseEstimate& estimate) {
  series(estimates_, estimate.source).push(estimate);
  states_.try_emplace(estimate.source, most_kept_).first->second.push(estimate.stamp, estimate.state);
  if (estimate.state == common::TrackingState::kLost) return;
  series(trajectories_, estimate.source).push({estimate.stamp, estimate.pose});
  const common::Nanoseconds end = estimate.stamp + common::kCoveredByPose;
  common::Nanoseconds& until = covered_until_.try_emplace(estimate.source, estimate.stamp).first->second;
  covered_[estimate.source] += std::max<common::Nanoseconds>(0, end - std::max(until, estimate.stamp));
  until = std::max(until, end);
}

void RunRecorder::on_corrected_pose(const fusion::CorrectedPose& pose) { on_estimate(pose.estimate); }

void RunRecorder::on_event(const common::Event& event) {
  // How it began and what happened last tell more than an even choice.
  if (events_.size() >= most_kept_) events_.erase(events_.begin() + static_cast<std::ptrdiff_t>(most_kept_ / 2));
  events_.push_back(event);
}

RunLog RunRecorder::log() const {
  RunLog log;
  for (const auto& [source, series] : trajectories_) log.trajectories[source] = series.items();
  for (const auto& [source, series] : estimates_) log.estimates[source] = series.items();
  for (const auto& [source, states] : states_) log.states[source] = states.stretches();
  log.covered = covered_;
  log.status = status_.items();
  log.events.assign(events_.begin(), events_.end());
  return log;
}

}  // namespace slamfuse::service
