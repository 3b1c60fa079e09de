// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/recording.hpp"
#include "idl/participant.hpp"
#include "service/input_state.hpp"
#include "service/live_inbox.hpp"
#include "service/odometry_guard.hpp"

namespace slamfuse::service {

/// What a live source listens to.
struct LiveSourceOptions {
  /// Of the default topics those take part that are heard; topics given must all be heard before it starts.
  LiveInboxOptions inbox;
  std::string base_frame = "base_link";
  std::map<std::string, double> readout;  ///< of a camera's rolling shutter [s], which camera_info cannot tell
  bool needs_laser = false;               ///< of the default topics, so that it does not start without
  bool needs_camera = false;              ///< likewise
  double settle = 0.5;                    ///< [s] after the last sensor appeared, for others to appear
  OdometryLimits odometry;                ///< beyond which it is not believed
};

/// The robot's topics as a recording that has no end: its messages in the order of arrival, however long ago they were
/// stamped. Messages are taken by the threads of a LiveInbox, checked and decoded where next() is called. Bad messages,
/// stamps that do not rise and impossible odometry come as RejectedMessage.
class LiveSource final : public common::Recording {
 public:
  /// Starts to listen. Setting `stop` ends every wait, and the recording. Errors: DDS makes no reader (kFailed), a
  /// sensor name whose kind is not known (kUsage).
  static common::Result<std::unique_ptr<LiveSource>> create(const idl::Participant& participant,
                                                            const LiveSourceOptions& options,
                                                            const std::atomic<bool>& stop);
  ~LiveSource() override;

  /// Waits until the geometry of the sensors is known, from the first scans, camera_info and transforms, and so decides
  /// what info() says. What arrived meanwhile is kept. `tell` hears now and then what is still missing. Error
  /// (kInterrupted): stopped.
  common::Result<void> prepare(const std::function<void(const std::string&)>& tell);

  const common::RecordingInfo& info() const override;
  /// The next message, waiting for it. Empty when stopped, or when what follows is for new modules, since a clock
  /// stepped back, a sensor can take part that could not before, or a camera's calibration changed: then
  /// restart_wanted().
  common::Result<std::optional<common::RecordingItem>> next() override;

  /// Why what follows is for new modules: next() goes on with it, and info() says what it is from now on. Only when
  /// nobody uses the info() of before any more. Empty once asked.
  std::optional<std::string> restart_wanted();

  /// From any thread: next() is to come to an end for this reason, as when a clock stepped back. Nothing more happens
  /// when it is at its end already and restart_wanted() was not asked yet.
  void end_session(const std::string& reason);

  /// A message of this sensor was not used, since its module was busy; from any thread.
  void dropped(const std::string& sensor);

  /// Every topic listened to; from any thread.
  std::vector<InputState> inputs() const;

 private:
  class Impl;
  explicit LiveSource(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace slamfuse::service
