// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "common/error.hpp"
#include "common/pose2.hpp"
#include "common/recording.hpp"
#include "common/sensor_message.hpp"
#include "idl/domain_settings.hpp"

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
  idl::Network network = idl::Network::kLoopback;
  double rate = 1.0;  ///< recording seconds in a second of wall time, above 0
  PlayStamps stamps = PlayStamps::kRecorded;
  double from = 0.0;         ///< [s] from the recording's start
  std::optional<double> to;  ///< [s] from the recording's start
  int times = 1;             ///< how often, 0: until stopped; see Continuation
  double wait = 2.0;         ///< [s] at most, for readers of every topic before the first message
};

/// Makes a recording that is played again follow on itself: its stamps go on rising, a second behind the last, and its
/// odometry goes on from where it was. So the robot seems to be carried back to the start.
class Continuation {
 public:
  /// The message as it is published; `again` begins the next turn.
  common::SensorMessage next(common::SensorMessage message);
  void again();

 private:
  std::optional<common::Nanoseconds> first_;  // of this turn, as recorded
  common::Nanoseconds newest_ = 0;            // as published
  common::Nanoseconds shift_ = 0;
  bool later_turn_ = false;
  std::map<std::string, common::Pose2> newest_odometry_;  // as published, by sensor
  std::map<std::string, common::Pose2> T_published_recorded_;
  std::set<std::string> aligned_;  // odometries that go on in this turn
};

/// Publishes a recording as ROS 2 topics, see RecordingPublisher. Messages that cannot be used are left out and
/// counted. `on_started` is called once interruption is worth an orderly end. Gives what was done in words. Errors: the
/// recording (kInvalidInput), DDS (kFailed), `stop` was set before the end (kInterrupted).
common::Result<std::string> run_play(const PlayRequest& request, const std::atomic<bool>& stop,
                                     const std::function<void()>& on_started);

}  // namespace slamfuse::service
