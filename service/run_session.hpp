// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/recording.hpp"
#include "fusion/fusion.hpp"
#include "laser_slam/laser_localization.hpp"
#include "laser_slam/laser_slam.hpp"
#include "service/external_poses.hpp"
#include "service/map_bundle.hpp"
#include "service/pipeline_observer.hpp"
#include "service/pipeline_requests.hpp"
#include "service/run_request.hpp"
#include "service/run_summary.hpp"
#include "visual_slam/visual_slam.hpp"

namespace slamfuse::service {

/// A recording with the modules that a request wants on it, ready to run once.
class RunSession {
 public:
  /// Opens the recording and the map and makes the modules; writes nothing. Errors: what cannot be read or is not in
  /// the recording (kInvalidInput), what the command line got wrong (kUsage).
  static common::Result<RunSession> create(const RunRequest& request);

  /// The same on messages that come from elsewhere; of the request's options on the recording none applies.
  static common::Result<RunSession> create(const RunRequest& request, std::unique_ptr<common::Recording> source);

  const common::RecordingInfo& recording() const { return recording_->info(); }

  /// The alignment the fusion uses; to be asked from within the observer's calls.
  std::optional<fusion::Alignment> alignment() const { return fusion_->alignment(); }

  /// The halves that make a map, and checkpoints of it.
  std::set<common::PoseSource> map_makers() const;

  /// Runs the recording through and gathers the results. `observer` (may be missing) watches. Setting `stop` ends it
  /// early with what there is so far, marked incomplete. `requests` (may be missing) come in while it runs. Errors: no
  /// module made a pose (kFailed), and those of run_pipeline() and judge().
  common::Result<RunSummary> run(PipelineObserver* observer, const std::atomic<bool>& stop,
                                 PipelineRequests* requests = nullptr);

 private:
  explicit RunSession(const RunRequest& request) : request_(request) {}
  common::Result<void> make_parts();
  common::Result<void> make_laser();
  common::Result<void> make_localization(const std::string& sensor);
  common::Result<void> make_visual();
  common::Result<void> check_cameras(const std::vector<std::string>& cameras) const;
  common::Result<void> restore_map();
  common::Result<void> restore_visual_map(const LoadedMapBundle& bundle);
  /// The laser half, whichever it is; null without one.
  common::SlamModule* laser() const;
  /// The visual half, whichever it is; null without one.
  common::SlamModule* visual() const;
  /// Whether a laser half of ours has a map.
  bool has_laser_map() const { return laser_ || localization_; }
  /// The poses of another system on this sensor, if the recording has them.
  std::unique_ptr<ExternalPoses> external(const std::string& sensor) const;
  /// How much of what grows with time is kept: of a recording, all.
  std::size_t most_kept() const;
  common::OccupancyGrid grid() const;
  ModuleCheckpoint laser_checkpoint() const;
  ModuleCheckpoint visual_checkpoint() const;
  void gather(RunSummary& summary) const;
  std::set<std::string> free_scale() const;  // trajectories that have no metres

  RunRequest request_;
  std::optional<fusion::Alignment> saved_alignment_;  // when both halves are in the maps of one bundle
  std::unique_ptr<common::Recording> recording_;
  std::unique_ptr<laser_slam::LaserSlam> laser_;  // in mode slam
  std::unique_ptr<laser_slam::LaserLocalization> localization_;
  std::string localization_state_;  // of the map localised in, to be handed on as it is
  std::unique_ptr<visual_slam::VisualSlam> visual_;
  std::map<std::string, common::CameraCalibration> cameras_;  // of the visual half
  std::unique_ptr<ExternalPoses> external_laser_;             // in the place of ours
  std::unique_ptr<ExternalPoses> external_visual_;            // likewise
  std::unique_ptr<fusion::Fusion> fusion_;
};

}  // namespace slamfuse::service
