// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "common/error.hpp"
#include "service/live_source.hpp"
#include "service/run_request.hpp"

namespace slamfuse::service {

/// What `slamfuse serve` was asked for.
struct ServeRequest {
  LiveSourceOptions source;
  RunRequest run;  ///< its options on a recording do not apply
};

/// Hears the outcome of a service whose results are written, or that has none.
using OnSaved = std::function<void(const common::Result<std::string>&)>;

/// Runs the pipeline on a robot's topics and publishes what it makes until `stop` is set, which is its normal end: then
/// everything `run` writes is in the output folder. Meanwhile the folder's `map` is saved every
/// ServiceOptions::save_interval, and operators are served (OperatorServices). When the robot's clock steps back, what
/// there is is saved and new modules go on in that map. `tell` hears news for a log; `on_started` is called once
/// interruption is worth an orderly end, `on_saved` with the outcome once there is nothing left but to leave DDS, which
/// may hang. Gives the outcome in words. Errors: output folder or map (kInvalidInput), DDS
/// or the pipeline (kFailed), stopped before there was anything to do (kInterrupted).
common::Result<std::string> run_serve(const ServeRequest& request, const std::function<void(const std::string&)>& tell,
                                      const std::atomic<bool>& stop, const std::function<void()>& on_started,
                                      const OnSaved& on_saved);

}  // namespace slamfuse::service
