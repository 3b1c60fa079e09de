// SPDX-License-Identifier: BSD-3-Clause
#include "service/live_inbox.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "common/ros_topics.hpp"
#include "service/message_size.hpp"
#include "service/sensor_discovery.hpp"
#include "service/sensor_topic.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using common::Result;
using common::SensorKind;

/// How long a thread may take to notice that it is to end.
constexpr auto kNap = 50ms;
/// What a topic of poses may be.
const char* const kPoseTypes =
    "geometry_msgs/msg/PoseWithCovarianceStamped, geometry_msgs/msg/PoseStamped or nav_msgs/msg/Odometry";
/// Cameras listened for when nobody names any.
constexpr int kDefaultCameras = 4;

std::string without_slash(const std::string& topic) { return topic.starts_with('/') ? topic.substr(1) : topic; }

}  // namespace

LiveInbox::LiveInbox(LiveInboxOptions options, idl::Participant participant, idl::Publications publications)
    : options_(std::move(options)), participant_(std::move(participant)), publications_(std::move(publications)) {}

LiveInbox::~LiveInbox() {
  for (auto& thread : threads_) thread.request_stop();
}

Result<void> LiveInbox::listen() {
  if (auto done = listen_for<idl::TFMessage>("", "tf_static", idl::QosProfile::kStaticTransformInput, false); !done)
    return done;
  if (auto done = listen_for<idl::TFMessage>("", "tf", idl::QosProfile::kTransformInput, false); !done) return done;
  if (options_.topics.empty()) return listen_to_defaults();
  for (const auto& [sensor, topic] : options_.topics) {
    if (auto done = listen_to(sensor, without_slash(topic), true); !done) return done;
  }
  return {};
}

Result<void> LiveInbox::listen_to_defaults() {
  if (auto done = listen_to("odom0", "odom", false); !done) return done;
  if (options_.lasers) {
    if (auto done = listen_to("laser0", "scan", false); !done) return done;
  }
  for (int i = 0; options_.cameras && i < kDefaultCameras; ++i) {
    const std::string camera = fmt::format("cam{}", i);
    const std::string topic = topic_of(camera, SensorKind::kCamera);
    if (auto done = listen_to(camera, topic, false); !done) return done;
    if (auto done = listen_for<idl::CompressedImage>(camera, topic + common::kCompressedEnding,
                                                     idl::QosProfile::kSensorInput, false);
        !done)
      return done;
  }
  return {};
}

Result<void> LiveInbox::listen_to(const std::string& sensor, const std::string& topic, bool required) {
  constexpr auto kSensor = idl::QosProfile::kSensorInput;
  const auto kind = kind_of_sensor(sensor);
  if (!kind) {
    return common::usage_error(
        fmt::format("--topic {}: allowed are laser0, odom0, cam0, cam1, ..., laser_pose and visual_pose (tf and "
                    "tf_static are always "
                    "heard)",
                    sensor));
  }
  if (*kind == SensorKind::kLaser) return listen_for<idl::LaserScan>(sensor, topic, kSensor, required);
  if (*kind == SensorKind::kPose) {
    listen_for_poses(sensor, topic, required);
    return {};
  }
  if (*kind == SensorKind::kOdometry) return listen_for<idl::Odometry>(sensor, topic, kSensor, required);
  if (auto done = listen_for<idl::CameraInfo>(sensor, common::camera_info_topic(topic), kSensor, required); !done)
    return done;
  if (topic.ends_with(common::kCompressedEnding))
    return listen_for<idl::CompressedImage>(sensor, topic, kSensor, required);
  return listen_for<idl::Image>(sensor, topic, kSensor, required);
}

template <class T>
Result<void> LiveInbox::listen_for(const std::string& sensor, const std::string& topic, idl::QosProfile profile,
                                   bool required) {
  auto made = idl::Reader<T>::create(participant_, topic, profile);
  if (!made) return tl::unexpected(made.error());
  const auto reader = std::make_shared<idl::Reader<T>>(*std::move(made));
  const std::size_t index = add_input(sensor, topic, idl::ros_type_name<T>(), required);
  {
    const std::lock_guard lock(mutex_);
    inputs_[index].health = [reader] { return reader->health(); };
  }
  threads_.emplace_back([this, reader, index](const std::stop_token& done) { receive(*reader, index, done); });
  return {};
}

std::size_t LiveInbox::add_input(const std::string& sensor, const std::string& topic, const std::string& type,
                                 bool required) {
  const std::lock_guard lock(mutex_);
  Input input;
  input.state.sensor = sensor;
  input.state.topic = topic;
  input.state.type = type;
  input.state.required = required;
  inputs_.push_back(std::move(input));
  return inputs_.size() - 1;
}

template <class T>
void LiveInbox::receive(idl::Reader<T>& reader, std::size_t index, const std::stop_token& done) {
  while (!done.stop_requested()) {
    auto taken = reader.take(kNap);
    if (!taken) {
      std::this_thread::sleep_for(kNap);
    } else if (*taken) {
      arrived(index, std::move(**taken), reader.sender());
    }
  }
}

void LiveInbox::listen_for_poses(const std::string& sensor, const std::string& topic, bool required) {
  const std::size_t index = add_input(sensor, topic, kPoseTypes, required);
  threads_.emplace_back([this, topic, index](const std::stop_token& done) {
    while (!done.stop_requested()) {
      for (const auto& publication : publications_.look()) {
        if (publication.topic != topic) continue;
        if (receive_if<idl::PoseWithCovarianceStamped>(publication.type, topic, index, done)) return;
        if (receive_if<idl::PoseStamped>(publication.type, topic, index, done)) return;
        if (receive_if<idl::Odometry>(publication.type, topic, index, done)) return;
      }
      std::this_thread::sleep_for(kNap);
    }
  });
}

template <class T>
bool LiveInbox::receive_if(const std::string& type, const std::string& topic, std::size_t index,
                           const std::stop_token& done) {
  if (type != idl::ros_type_name<T>()) return false;
  auto made = idl::Reader<T>::create(participant_, topic, idl::QosProfile::kSensorInput);
  if (!made) return false;
  const auto reader = std::make_shared<idl::Reader<T>>(*std::move(made));
  {
    const std::lock_guard lock(mutex_);
    inputs_[index].state.type = type;
    inputs_[index].health = [reader] { return reader->health(); };
  }
  receive(*reader, index, done);
  return true;
}

template <class T>
void LiveInbox::arrived(std::size_t index, idl::Message<T> message, std::uint64_t publisher) {
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  InputState& state = inputs_[index].state;
  ++state.received;
  state.last_arrival = now;
  const std::size_t memory = memory_of(*message);
  if (queue_.size() >= options_.queue_capacity || queued_memory_ + memory > options_.queue_memory) {
    ++state.dropped;
    return;
  }
  queued_memory_ += memory;
  queue_.push_back({index, now, std::move(message), memory, publisher});
  filled_.notify_one();
}

std::optional<LiveArrival> LiveInbox::take(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  if (!filled_.wait_for(lock, patience, [this] { return !queue_.empty(); })) return std::nullopt;
  std::optional<LiveArrival> arrival(std::move(queue_.front()));
  queue_.pop_front();
  queued_memory_ -= arrival->memory;
  return arrival;
}

std::string LiveInbox::sensor_of(std::size_t input) const {
  const std::lock_guard lock(mutex_);
  return inputs_[input].state.sensor;
}

void LiveInbox::used(std::size_t input, common::Nanoseconds stamp, common::Nanoseconds clock_offset) {
  const std::lock_guard lock(mutex_);
  inputs_[input].state.last_stamp = stamp;
  inputs_[input].state.clock_offset = clock_offset;
}

void LiveInbox::dropped(std::size_t input) {
  const std::lock_guard lock(mutex_);
  ++inputs_[input].state.dropped;
}

void LiveInbox::dropped(const std::string& sensor) {
  const std::lock_guard lock(mutex_);
  const auto data = std::ranges::find_if(inputs_, [&sensor](const Input& input) {
    return input.state.sensor == sensor && input.state.last_stamp && !is_calibration(input.state);
  });
  if (data != inputs_.end()) ++data->state.dropped;
}

InputState LiveInbox::rejected(std::size_t input, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  InputState& state = inputs_[input].state;
  ++state.rejected;
  state.last_rejection = reason;
  return state;
}

std::vector<InputState> LiveInbox::topics() const {
  std::vector<InputState> states;
  const std::lock_guard lock(mutex_);
  for (const Input& input : inputs_) states.push_back(input.state);
  return states;
}

std::vector<InputState> LiveInbox::inputs() const {
  std::vector<InputState> states;
  const auto publications = publications_.look();
  const std::lock_guard lock(mutex_);
  for (const Input& input : inputs_) {
    InputState state = input.state;
    const idl::ReaderHealth health = input.health ? input.health() : idl::ReaderHealth();
    state.writers = health.matched_writers;
    state.incompatible_qos = health.incompatible_qos;
    state.lost = health.lost;
    for (const auto& publication : publications) {
      const bool other = publication.topic == state.topic && publication.type != state.type && state.writers == 0;
      if (other) state.other_type = publication.type;
    }
    states.push_back(std::move(state));
  }
  return states;
}

}  // namespace slamfuse::service
