// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "common/error.hpp"
#include "common/time.hpp"
#include "idl/participant.hpp"
#include "idl/publications.hpp"
#include "idl/reader.hpp"
#include "service/input_state.hpp"

namespace slamfuse::service {

/// Which topics are listened to, and how much may wait.
struct LiveInboxOptions {
  /// Topics by sensor name, `laser_pose` and `visual_pose` being the poses of other SLAM systems in the place of a
  /// half; empty: `scan`, `odom` and `cam0/image_raw` to `cam3/image_raw`, raw or compressed.
  std::map<std::string, std::string> topics;
  bool lasers = true;                               ///< false: default topics without `scan`
  bool cameras = true;                              ///< false: default topics without cameras
  std::size_t queue_capacity = 256;                 ///< messages that may wait; more are dropped and counted
  std::size_t queue_memory = std::size_t{1} << 28;  ///< [bytes] that they may take together; likewise
};

/// A message of any of the types that a robot's topics may have.
using LivePayload =
    std::variant<idl::Message<idl::LaserScan>, idl::Message<idl::Odometry>, idl::Message<idl::Image>,
                 idl::Message<idl::CompressedImage>, idl::Message<idl::CameraInfo>, idl::Message<idl::TFMessage>,
                 idl::Message<idl::PoseWithCovarianceStamped>, idl::Message<idl::PoseStamped>>;

/// A message as it came.
struct LiveArrival {
  std::size_t input = 0;  ///< the topic, see LiveInbox
  std::chrono::steady_clock::time_point at;
  LivePayload payload;
  std::size_t memory = 0;       ///< [bytes]
  std::uint64_t publisher = 0;  ///< see idl::Reader::sender()
};

/// Takes the messages of a robot's topics, in the order of their arrival, and keeps the books of each topic. Each has a
/// thread that does nothing but take messages.
class LiveInbox {
 public:
  LiveInbox(LiveInboxOptions options, idl::Participant participant, idl::Publications publications);
  /// Waits for its threads.
  ~LiveInbox();

  /// Starts to listen, to tf and tf_static too; once. Errors: DDS makes no reader (kFailed), a sensor name whose kind
  /// is not known (kUsage).
  common::Result<void> listen();

  /// The next message; nothing when none comes within `patience`.
  std::optional<LiveArrival> take(std::chrono::milliseconds patience);

  /// The sensor a topic is heard for; empty for transforms.
  std::string sensor_of(std::size_t input) const;
  /// Of a topic's books: its message was used, was dropped elsewhere, was rejected for a reason. Gives the topic's
  /// state after that.
  void used(std::size_t input, common::Nanoseconds stamp, common::Nanoseconds clock_offset);
  void dropped(std::size_t input);
  InputState rejected(std::size_t input, const std::string& reason);
  /// The same as dropped() of the topic on which this sensor's data comes; from any thread.
  void dropped(const std::string& sensor);

  /// Every topic listened to as far as its messages tell.
  std::vector<InputState> topics() const;
  /// The same with what DDS knows of its writers, all but `in_use`; from any thread.
  std::vector<InputState> inputs() const;

 private:
  /// What one topic is listened to for.
  struct Input {
    InputState state;
    std::function<idl::ReaderHealth()> health;
  };

  common::Result<void> listen_to_defaults();
  common::Result<void> listen_to(const std::string& sensor, const std::string& topic, bool required);
  template <class T>
  common::Result<void> listen_for(const std::string& sensor, const std::string& topic, idl::QosProfile profile,
                                  bool required);
  /// Poses come in one of several types: that of the first who publishes the topic is listened to.
  void listen_for_poses(const std::string& sensor, const std::string& topic, bool required);
  std::size_t add_input(const std::string& sensor, const std::string& topic, const std::string& type, bool required);
  template <class T>
  void receive(idl::Reader<T>& reader, std::size_t index, const std::stop_token& done);
  /// Receives until the end when the type is T.
  template <class T>
  bool receive_if(const std::string& type, const std::string& topic, std::size_t index, const std::stop_token& done);
  template <class T>
  void arrived(std::size_t index, idl::Message<T> message, std::uint64_t publisher);

  const LiveInboxOptions options_;
  idl::Participant participant_;
  idl::Publications publications_;

  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable filled_;
  std::vector<Input> inputs_;
  std::deque<LiveArrival> queue_;
  std::size_t queued_memory_ = 0;

  std::vector<std::jthread> threads_;  // last: they end before what they use
};

}  // namespace slamfuse::service
