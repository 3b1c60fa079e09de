// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <vector>

#include "common/pose_estimate.hpp"
#include "common/trajectory.hpp"
#include "fusion/status.hpp"
#include "service/pipeline_observer.hpp"
#include "service/state_history.hpp"
#include "service/thinned_series.hpp"

namespace slamfuse::service {

/// Everything a run told, in order.
struct RunLog {
  /// Poses as they were known at their moment, by source; none while LOST.
  std::map<common::PoseSource, common::Trajectory2> trajectories;
  /// Every estimate of laser, visual and fused, LOST ones too.
  std::map<common::PoseSource, std::vector<common::PoseEstimate>> estimates;
  /// When each of them was in which state; of all estimates, kept or not.
  std::map<common::PoseSource, std::vector<StateStretch>> states;
  std::vector<fusion::StatusEntry> status;
  std::vector<common::Event> events;
  /// Time that lies within kCoveredByPose after a pose that was not LOST, by source; of all poses, kept or not.
  std::map<common::PoseSource, common::Nanoseconds> covered;
};

/// Keeps what the output files are made from; of each series at most `most_kept`, evenly thinned beyond, of events the
/// first half and the newest.
class RunRecorder : public PipelineObserver {
 public:
  explicit RunRecorder(std::size_t most_kept = ThinnedSeries<int>::kAll);

  void on_odometry(const common::WheelOdometry& odometry) override;
  void on_estimate(const common::PoseEstimate& estimate) override;
  void on_corrected_pose(const fusion::CorrectedPose& pose) override;
  void on_status(const fusion::StatusEntry& status) override { status_.push(status); }
  void on_event(const common::Event& event) override;

  RunLog log() const;

 private:
  template <class T>
  using BySource = std::map<common::PoseSource, ThinnedSeries<T>>;

  template <class T>
  ThinnedSeries<T>& series(BySource<T>& by_source, common::PoseSource source) {
    return by_source.try_emplace(source, most_kept_).first->second;
  }

  const std::size_t most_kept_;
  BySource<common::StampedPose2> trajectories_;
  BySource<common::PoseEstimate> estimates_;
  std::map<common::PoseSource, StateHistory> states_;
  std::map<common::PoseSource, common::Nanoseconds> covered_;
  std::map<common::PoseSource, common::Nanoseconds> covered_until_;
  ThinnedSeries<fusion::StatusEntry> status_;
  std::deque<common::Event> events_;
};

}  // namespace slamfuse::service
