// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/landmark.hpp"
#include "common/occupancy_grid.hpp"
#include "common/trajectory.hpp"
#include "fusion/alignment.hpp"
#include "service/dds_options.hpp"
#include "service/dds_outputs.hpp"
#include "service/pipeline_observer.hpp"
#include "service/unsent_messages.hpp"

namespace slamfuse::service {

/// What is known at the end of a run, in the map frame.
struct DdsFinalState {
  const common::OccupancyGrid* map = nullptr;  ///< may be missing
  common::Trajectory2 laser = {};
  common::Trajectory2 visual = {};  ///< brought over by the alignment; empty when it was refused
  common::Trajectory2 fused = {};
  std::vector<common::Landmark> landmarks = {};  ///< positions brought over likewise
};

/// Publishes a run as ROS 2 topics while it goes on: `slamfuse/pose`, `tf` (map -> odom), `map`, `slamfuse/path/fused`,
/// `.../laser`, `.../visual`, `slamfuse/landmarks` and `slamfuse/status` (DESIGN section 7). Stamps are those of the
/// measurements.
class DdsPublisher : public PipelineObserver {
 public:
  /// The alignment in use, or nothing: visual poses are published in the map frame, so only with an accepted one. Asked
  /// from within the observer's calls.
  using CurrentAlignment = std::function<std::optional<fusion::Alignment>()>;

  /// `outputs` may have served another session before.
  DdsPublisher(std::shared_ptr<DdsOutputs> outputs, const DdsOptions& options, CurrentAlignment current_alignment);
  ~DdsPublisher() override;

  void on_estimate(const common::PoseEstimate& estimate) override;
  /// Stamps of `slamfuse/pose` and `tf` rise: what comes late, or corrects a pose of the same stamp, is in the next.
  void on_corrected_pose(const fusion::CorrectedPose& pose) override;
  /// A system in the place of a half that was started again in the map it had is told where it is.
  void on_event(const common::Event& event) override;
  /// A pose that a system in the place of a half is told.
  void on_command(common::PoseSource target, const common::Command& command) override;
  void on_status(const fusion::StatusEntry& status) override;
  /// Landmarks, when they are aligned.
  void on_checkpoint(common::PoseSource source, const std::shared_ptr<const ModuleCheckpoint>& checkpoint) override;
  void on_map(common::Nanoseconds stamp, const std::shared_ptr<const common::OccupancyGrid>& map) override;

  /// Publishes the outcome; whether listeners have it, DdsOutputs knows.
  void finish(const DdsFinalState& state);

  const UnsentMessages& unsent() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace slamfuse::service
