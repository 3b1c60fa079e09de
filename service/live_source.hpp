// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/recording.hpp"
#include "idl/participant.hpp"

namespace slamfuse::service {

/// What a live source listens to.
struct LiveSourceOptions {
  /// Topics by sensor name, `laser_pose` and `visual_pose` being the poses of other SLAM systems in the place of a
  /// half; empty: `scan`, `odom` and `cam0/image_raw` to `cam3/image_raw`, raw or compressed, of which those take part
  /// that are heard. Topics given here must all be heard before it starts.
  std::map<std::string, std::string> topics;
  bool lasers = true;   ///< false: default topics without `scan`
  bool cameras = true;  ///< false: default topics without cameras
  std::string base_frame = "base_link";
  std::map<std::string, double> readout;  ///< of a camera's rolling shutter [s], which camera_info cannot tell
  double settle = 0.5;                    ///< [s] after the last sensor appeared, for others to appear
  std::size_t queue_capacity = 256;       ///< messages that may wait; more are dropped and counted
  std::size_t queue_memory = std::size_t{1} << 28;  ///< [bytes] that they may take together; likewise
};

/// How a topic fares.
struct InputState {
  std::string sensor;  ///< empty for what belongs to no sensor
  std::string topic;
  std::string type;              ///< "sensor_msgs/msg/LaserScan"
  bool required = false;         ///< named by the user
  bool in_use = false;           ///< by a module
  int writers = 0;               ///< matched
  std::string incompatible_qos;  ///< the policy that kept a writer from matching; empty: none did
  std::string other_type;        ///< that somebody publishes under this name while nobody publishes `type`
  std::size_t received = 0;
  std::size_t rejected = 0;
  std::size_t dropped = 0;     ///< the queue was full
  std::size_t lost = 0;        ///< never arrived, as the transport knows
  std::string last_rejection;  ///< why
  std::optional<common::Nanoseconds> last_stamp;
  std::optional<std::chrono::steady_clock::time_point> last_arrival;
  std::optional<common::Nanoseconds> clock_offset;  ///< clock at arrival minus stamp, of the last message
};

/// The robot's topics as a recording that has no end: its messages in the order of arrival, however long ago they were
/// stamped. Each topic has a thread that does nothing but take messages; they are checked and decoded where next() is
/// called. Bad messages and stamps that do not rise come as RejectedMessage.
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
  /// The next message, waiting for it. Empty when stopped, or when a clock stepped back: then restart_wanted().
  common::Result<std::optional<common::RecordingItem>> next() override;

  /// Why what follows belongs to another time: next() goes on with it, for new modules. Empty once asked.
  std::optional<std::string> restart_wanted();

  /// From any thread: next() is to come to an end for this reason, as when a clock stepped back.
  void end_session(const std::string& reason);

  /// Every topic listened to; from any thread.
  std::vector<InputState> inputs() const;

 private:
  class Impl;
  explicit LiveSource(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace slamfuse::service
