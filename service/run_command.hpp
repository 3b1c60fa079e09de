// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "common/error.hpp"
#include "service/pipeline_observer.hpp"
#include "service/run_request.hpp"

namespace slamfuse::service {

/// Runs a recording and writes everything DESIGN section 5 promises into the output folder. `progress` (may be missing)
/// watches. Gives the outcome in words. `on_started` is called once the recording is open: from then on `stop` ends the
/// run in an orderly way; before, nothing is written yet and nothing looks at it.
///
/// Errors: unreadable input, an output folder that cannot be written to (kInvalidInput, nothing written); a disk that
/// is full (kFailed, nothing written); no module made a pose (kFailed, written all the same, to see why); stopped
/// (kInterrupted, what was computed is written and marked incomplete).
common::Result<std::string> run_recording(const RunRequest& request, PipelineObserver* progress,
                                          const std::atomic<bool>& stop, const std::function<void()>& on_started);

}  // namespace slamfuse::service
