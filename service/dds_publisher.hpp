// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/error.hpp"
#include "common/landmark.hpp"
#include "common/occupancy_grid.hpp"
#include "common/trajectory.hpp"
#include "fusion/alignment.hpp"
#include "idl/participant.hpp"
#include "service/dds_options.hpp"
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

  /// Waits for listeners as the options say. Error (kFailed): DDS makes no writer.
  static common::Result<std::unique_ptr<DdsPublisher>> create(const idl::Participant& participant,
                                                              const DdsOptions& options,
                                                              CurrentAlignment current_alignment);
  ~DdsPublisher() override;

  void on_estimate(const common::PoseEstimate& estimate) override;
  void on_corrected_pose(const fusion::CorrectedPose& pose) override;
  void on_status(const fusion::StatusEntry& status) override;
  /// Landmarks, when they are aligned.
  void on_checkpoint(common::PoseSource source, const std::shared_ptr<const ModuleCheckpoint>& checkpoint) override;
  void on_map(common::Nanoseconds stamp, const std::shared_ptr<const common::OccupancyGrid>& map) override;

  /// Publishes the outcome and waits until the listeners have it, as long as the options allow.
  void finish(const DdsFinalState& state) { finish(state, linger()); }
  /// The same, waiting so long [s] at most.
  void finish(const DdsFinalState& state, double patience);

  const UnsentMessages& unsent() const;

 private:
  double linger() const;
  struct State;
  explicit DdsPublisher(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace slamfuse::service
