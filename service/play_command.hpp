// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "common/error.hpp"
#include "common/recording.hpp"

namespace slamfuse::service {

/// Which stamps played messages carry.
enum class PlayStamps {
  kRecorded,  ///< as in the recording
  kNow,       ///< all moved by the same time, so that the first is the clock's now
};

/// What `slamfuse play` was asked for.
struct PlayRequest {
  std::filesystem::path recording;
  common::RecordingOptions recording_options;
  double rate = 1.0;  ///< recording seconds in a second of wall time, above 0
  PlayStamps stamps = PlayStamps::kRecorded;
  double from = 0.0;         ///< [s] from the recording's start
  std::optional<double> to;  ///< [s] from the recording's start
  double wait = 2.0;         ///< [s] at most, for readers of every topic before the first message
};

/// Publishes a recording as ROS 2 topics, see RecordingPublisher. Messages that cannot be used are left out and
/// counted. `on_started` is called once interruption is worth an orderly end. Gives what was done in words. Errors: the
/// recording (kInvalidInput), DDS (kFailed), `stop` was set before the end (kInterrupted).
common::Result<std::string> run_play(const PlayRequest& request, const std::atomic<bool>& stop,
                                     const std::function<void()>& on_started);

}  // namespace slamfuse::service
