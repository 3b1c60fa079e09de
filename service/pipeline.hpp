// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>
#include <map>
#include <vector>

#include "common/error.hpp"
#include "common/pose_estimate.hpp"
#include "common/recording.hpp"
#include "service/fusion_stage.hpp"
#include "service/module_counters.hpp"
#include "service/module_stage.hpp"
#include "service/pipeline_observer.hpp"
#include "service/pipeline_requests.hpp"

namespace slamfuse::service {

struct PipelineOptions {
  int threads = 1;  ///< 1: everything in the calling thread; more: one for each module, one for the fusion
  std::size_t queue_capacity = 64;  ///< inputs waiting for the fusion, and in a replay for a module
  /// Inputs from a fusion step to its commands taking effect, see CommandPath; live at least one more than all other
  /// modules' backlogs together.
  int command_delay = 16;
  common::Nanoseconds map_interval = 0;         ///< recording time between map pictures for the observer; 0: none
  common::Nanoseconds checkpoint_interval = 0;  ///< recording time between checkpoints for the observer; 0: none
  /// Scans, or images, that may wait for their module; more are dropped and counted, and the fusion gets everything as
  /// soon as it is there, so the order depends on the modules' pace. 0: a replay, nothing is dropped.
  /// Only with several threads: one thread never has anything waiting.
  int live_backlog = 0;
  std::size_t most_kept = ThinnedSeries<UpdateTime>::kAll;  ///< update times of each module; more are thinned
  double rate = 0.0;  ///< recording seconds in a second of wall time; 0: as fast as possible
};

/// The parts a pipeline connects; none is owned.
struct PipelineParts {
  common::Recording* recording = nullptr;
  std::vector<PipelineModule> modules;
  FusionStage* fusion = nullptr;
  PipelineObserver* observer = nullptr;
  PipelineRequests* requests = nullptr;  ///< may be missing
};

struct PipelineOutcome {
  bool interrupted = false;                               ///< the stop flag ended it early
  std::map<common::PoseSource, ModuleCounters> counters;  ///< of every module, and of the fusion as kFused
};

/// Runs a recording through the modules and the fusion (DESIGN section 3):
///
///     recording -> numbered inputs -> each module that wants them -> merge in order of (index, source) -> fusion
///                                        ^------------- commands, `command_delay` inputs later -------------'
///
/// In replay the calls on every module, on the fusion and on the observer are the same whatever the number of threads
/// and their timing. Setting `stop` ends the run early, within the time of one update. Errors: the recording's
/// structure turned out unreadable on the way (kInvalidInput), or a part threw (kFailed); what the observer got stays
/// valid.
common::Result<PipelineOutcome> run_pipeline(const PipelineParts& parts, const PipelineOptions& options,
                                             const std::atomic<bool>& stop);

}  // namespace slamfuse::service
