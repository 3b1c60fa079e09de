// SPDX-License-Identifier: BSD-3-Clause
#include "service/live_source.hpp"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/ros_conversions.hpp"
#include "common/ros_topics.hpp"
#include "idl/publications.hpp"
#include "idl/reader.hpp"
#include "service/clock_now.hpp"
#include "service/message_size.hpp"
#include "service/ros_to_sensor.hpp"
#include "service/sensor_discovery.hpp"
#include "service/sensor_topic.hpp"
#include "service/stamp_guard.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using common::Result;
using common::SensorKind;
using Clock = std::chrono::steady_clock;

/// How long a request to stop may go unnoticed.
constexpr auto kNap = 50ms;
/// Between two reports on what is missing.
constexpr auto kReport = 5s;
/// What a topic of poses may be.
const char* const kPoseTypes =
    "geometry_msgs/msg/PoseWithCovarianceStamped, geometry_msgs/msg/PoseStamped or nav_msgs/msg/Odometry";
/// Cameras listened for when nobody names any.
constexpr int kDefaultCameras = 4;

using Payload =
    std::variant<idl::Message<idl::LaserScan>, idl::Message<idl::Odometry>, idl::Message<idl::Image>,
                 idl::Message<idl::CompressedImage>, idl::Message<idl::CameraInfo>, idl::Message<idl::TFMessage>,
                 idl::Message<idl::PoseWithCovarianceStamped>, idl::Message<idl::PoseStamped>>;

/// A message as it came.
struct Arrival {
  std::size_t input = 0;
  Clock::time_point at;
  Payload payload;
  std::size_t memory = 0;  ///< [bytes]
};

/// What one topic is listened to for.
struct Input {
  InputState state;
  std::function<idl::ReaderHealth()> health;
};

std::string without_slash(const std::string& topic) { return topic.starts_with('/') ? topic.substr(1) : topic; }

}  // namespace

class LiveSource::Impl {
 public:
  Impl(LiveSourceOptions options, const std::atomic<bool>& stop, idl::Participant participant,
       idl::Publications publications)
      : options_(std::move(options)),
        stop_(stop),
        participant_(std::move(participant)),
        publications_(std::move(publications)),
        discovery_(options_.base_frame) {
    info_.path = "DDS";
    info_.format = "dds";
  }

  ~Impl() {
    for (auto& thread : threads_) thread.request_stop();
  }

  Result<void> listen() {
    if (auto done = listen_for<idl::TFMessage>("", "tf_static", idl::QosProfile::kStaticTransformInput, false); !done)
      return done;
    if (auto done = listen_for<idl::TFMessage>("", "tf", idl::QosProfile::kTransformInput, false); !done) return done;
    if (options_.topics.empty()) return listen_to_defaults();
    for (const auto& [sensor, topic] : options_.topics) {
      if (auto done = listen_to(sensor, without_slash(topic), true); !done) return done;
    }
    return {};
  }

  Result<void> prepare(const std::function<void(const std::string&)>& tell) {
    auto settled = Clock::now() + kReport;
    auto report = Clock::now() + kReport;
    std::size_t known = 0;
    while (!stop_) {
      if (auto arrival = take(kNap)) {
        learn(*arrival);
        backlog_.push_back(std::move(*arrival));
        trim_backlog();
      }
      const auto now = Clock::now();
      const std::size_t usable = discovery_.usable_sensors().size();
      if (usable != known) settled = now + std::chrono::duration_cast<Clock::duration>(settle());
      known = usable;
      const std::string missing = missing_sensors();
      if (missing.empty() && (all_named() || now >= settled)) {
        decide();
        return {};
      }
      if (now >= report) {
        if (!missing.empty()) tell("waiting for " + missing);
        report = now + kReport;
      }
    }
    return tl::unexpected(common::Error{common::ErrorKind::kInterrupted, "stopped before any sensor was heard"});
  }

  Result<std::optional<common::RecordingItem>> next() {
    while (!stop_ && !restart_) {
      restart_ = take_end_wanted();
      if (restart_) break;
      std::optional<Arrival> arrival;
      if (backlog_.empty()) {
        arrival = take(kNap);
      } else {
        arrival = std::move(backlog_.front());
        backlog_.pop_front();
      }
      if (!arrival) continue;
      if (auto item = to_item(*arrival)) return item;
    }
    return std::optional<common::RecordingItem>();
  }

  void end_session(const std::string& reason) {
    const std::lock_guard lock(mutex_);
    end_wanted_ = reason;
  }

  std::optional<std::string> restart_wanted() { return std::exchange(restart_, std::nullopt); }

  const common::RecordingInfo& info() const { return info_; }

  std::vector<InputState> inputs() const {
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
      state.in_use = input.state.sensor.empty() || info_.sensors.contains(input.state.sensor);
      states.push_back(std::move(state));
    }
    return states;
  }

 private:
  // ---- listening

  Result<void> listen_to_defaults() {
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

  Result<void> listen_to(const std::string& sensor, const std::string& topic, bool required) {
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
  Result<void> listen_for(const std::string& sensor, const std::string& topic, idl::QosProfile profile, bool required) {
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

  std::size_t add_input(const std::string& sensor, const std::string& topic, const std::string& type, bool required) {
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
  void receive(idl::Reader<T>& reader, std::size_t index, const std::stop_token& done) {
    while (!done.stop_requested()) {
      auto taken = reader.take(kNap);
      if (!taken) {
        std::this_thread::sleep_for(kNap);
      } else if (*taken) {
        arrived(index, std::move(**taken));
      }
    }
  }

  /// Poses come in one of several types: that of the first who publishes the topic is listened to.
  void listen_for_poses(const std::string& sensor, const std::string& topic, bool required) {
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

  /// Receives until the end when the type is T.
  template <class T>
  bool receive_if(const std::string& type, const std::string& topic, std::size_t index, const std::stop_token& done) {
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
  void arrived(std::size_t index, idl::Message<T> message) {
    const auto now = Clock::now();
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
    queue_.push_back({index, now, std::move(message), memory});
    filled_.notify_one();
  }

  std::optional<std::string> take_end_wanted() {
    const std::lock_guard lock(mutex_);
    return std::exchange(end_wanted_, std::nullopt);
  }

  std::optional<Arrival> take(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    if (!filled_.wait_for(lock, patience, [this] { return !queue_.empty(); })) return std::nullopt;
    std::optional<Arrival> arrival(std::move(queue_.front()));
    queue_.pop_front();
    queued_memory_ -= arrival->memory;
    return arrival;
  }

  // ---- finding out what there is

  std::string sensor_of(const Arrival& arrival) const {
    const std::lock_guard lock(mutex_);
    return inputs_[arrival.input].state.sensor;
  }

  /// What arrived before everything is known waits, as far as there is room: the oldest goes.
  void trim_backlog() {
    backlog_memory_ += backlog_.back().memory;
    while (backlog_.size() > options_.queue_capacity || backlog_memory_ > options_.queue_memory) {
      {
        const std::lock_guard lock(mutex_);
        ++inputs_[backlog_.front().input].state.dropped;
      }
      backlog_memory_ -= backlog_.front().memory;
      backlog_.pop_front();
    }
  }

  void learn(const Arrival& arrival) {
    const std::string sensor = sensor_of(arrival);
    std::visit([&](const auto& message) { discovery_.hear(sensor, *message); }, arrival.payload);
  }

  bool all_named() const { return !options_.topics.empty(); }
  std::chrono::duration<double> settle() const { return std::chrono::duration<double>(options_.settle); }

  /// In words; empty when it can start.
  std::string missing_sensors() const {
    std::vector<std::string> missing;
    bool eyes = false;
    const std::lock_guard lock(mutex_);
    for (const Input& input : inputs_) {
      const InputState& state = input.state;
      if (state.sensor.empty()) continue;
      const bool heard = discovery_.usable(state.sensor);
      eyes |= heard && *kind_of_sensor(state.sensor) != SensorKind::kOdometry;
      if (!state.required || heard) continue;
      const std::string problem = discovery_.problem_of(state.sensor);
      missing.push_back(
          fmt::format("{} on {}{}", state.sensor, state.topic, problem.empty() ? std::string() : " (" + problem + ")"));
    }
    if (!missing.empty()) return fmt::format("{}", fmt::join(missing, ", "));
    return eyes ? std::string() : std::string("a laser, a calibrated camera or poses of another system");
  }

  /// Takes what has been found out as what this recording is.
  void decide() {
    common::RecordingInfo info = info_;
    discovery_.describe(info);
    for (const auto& [camera, readout] : options_.readout) {
      const auto found = info.calibration.cameras.find(camera);
      if (found != info.calibration.cameras.end()) found->second.readout = readout;
    }
    for (const auto& [sensor, about] : info.sensors) {
      if (about.kind == SensorKind::kOdometry || about.kind == SensorKind::kPose)
        T_child_base_[sensor] = discovery_.T_child_base(sensor);
    }
    // What is rejected before the first good message still happened about then, not in 1970.
    last_stamp_ = discovery_.newest_stamp();
    const std::lock_guard lock(mutex_);
    info_ = std::move(info);
  }

  // ---- messages

  std::optional<common::RecordingItem> to_item(const Arrival& arrival) {
    const std::string sensor = sensor_of(arrival);
    if (!info_.sensors.contains(sensor)) return std::nullopt;  // transforms, and sensors that do not take part
    if (const auto* info = std::get_if<idl::Message<idl::CameraInfo>>(&arrival.payload)) {
      return check_camera(arrival, sensor, **info);
    }
    auto message = decode(arrival.payload, sensor);
    if (!message) return reject(arrival, sensor, message.error().message);
    const common::Nanoseconds stamp = common::stamp_of(*message);
    const auto verdict = stamps_.judge(sensor, stamp, arrival.at);
    if (verdict.kind == StampGuard::Kind::kRefused) return reject(arrival, sensor, verdict.reason);
    if (verdict.kind == StampGuard::Kind::kSteppedBack) {
      stamps_.reset();
      restart_ = verdict.reason;
      return reject(arrival, sensor, verdict.reason);
    }
    const common::Nanoseconds offset = clock_now() - stamp;
    const std::lock_guard lock(mutex_);
    inputs_[arrival.input].state.last_stamp = last_stamp_ = stamp;
    inputs_[arrival.input].state.clock_offset = offset;
    return common::RecordingItem(std::move(*message));
  }

  Result<common::SensorMessage> decode(const Payload& payload, const std::string& sensor) const {
    return std::visit([&](const auto& message) { return this->decode(*message, sensor); }, payload);
  }
  Result<common::SensorMessage> decode(const idl::LaserScan& message, const std::string& sensor) const {
    const auto scan = from_ros(message);
    if (!scan) return tl::unexpected(scan.error());
    return common::to_laser_scan(*scan, sensor, info_.calibration.lasers.at(sensor));
  }
  Result<common::SensorMessage> decode(const idl::Odometry& message, const std::string& sensor) const {
    if (info_.sensors.at(sensor).kind == SensorKind::kPose) return to_pose(pose_from_ros(message), sensor);
    const auto odometry = from_ros(message);
    if (!odometry) return tl::unexpected(odometry.error());
    return common::to_wheel_odometry(*odometry, sensor, T_child_base_.at(sensor));
  }
  Result<common::SensorMessage> decode(const idl::Image& message, const std::string& sensor) const {
    const auto image = from_ros(message);
    if (!image) return tl::unexpected(image.error());
    return to_image(image->header, sensor, common::to_gray(*image, size_of(sensor)));
  }
  Result<common::SensorMessage> decode(const idl::CompressedImage& message, const std::string& sensor) const {
    const auto image = from_ros(message);
    if (!image) return tl::unexpected(image.error());
    return to_image(image->header, sensor, common::decode_gray_image(image->data, size_of(sensor)));
  }
  Result<common::SensorMessage> decode(const idl::PoseWithCovarianceStamped& message, const std::string& sensor) const {
    return to_pose(from_ros(message), sensor);
  }
  Result<common::SensorMessage> decode(const idl::PoseStamped& message, const std::string& sensor) const {
    return to_pose(from_ros(message), sensor);
  }
  Result<common::SensorMessage> to_pose(const Result<RosPose>& pose, const std::string& sensor) const {
    if (!pose) return tl::unexpected(pose.error());
    const common::Pose2 T_map_base = common::to_pose2(pose->pose) * T_child_base_.at(sensor);
    return common::ExternalPose{pose->header.stamp, sensor, pose->header.frame, T_map_base, pose->covariance};
  }
  static Result<common::SensorMessage> decode(const idl::CameraInfo&, const std::string&) {
    return common::invalid_input("not a sensor message");
  }
  static Result<common::SensorMessage> decode(const idl::TFMessage&, const std::string&) {
    return common::invalid_input("not a sensor message");
  }

  common::ImageSize size_of(const std::string& camera) const {
    const common::CameraCalibration& calibration = info_.calibration.cameras.at(camera);
    return {calibration.width, calibration.height};
  }
  static Result<common::SensorMessage> to_image(const common::RosHeader& header, const std::string& sensor,
                                                Result<common::GrayImage> gray) {
    if (!gray) return tl::unexpected(gray.error());
    return common::Image{header.stamp, sensor, gray->size.width, gray->size.height, std::move(gray->pixels)};
  }

  /// A calibration cannot change under way: what says so is told.
  std::optional<common::RecordingItem> check_camera(const Arrival& arrival, const std::string& sensor,
                                                    const idl::CameraInfo& message) {
    const auto info = from_ros(message);
    if (!info) return reject(arrival, sensor, info.error().message);
    const common::RosCameraInfo& known = discovery_.camera_info(sensor);
    if (info->k == known.k && info->d == known.d && info->width == known.width && info->height == known.height) {
      return std::nullopt;
    }
    return reject(arrival, sensor, "camera_info changed, which takes a restart; the first one is used");
  }

  common::RecordingItem reject(const Arrival& arrival, const std::string& sensor, const std::string& reason) {
    const std::lock_guard lock(mutex_);
    InputState& state = inputs_[arrival.input].state;
    ++state.rejected;
    state.last_rejection = reason;
    return common::RejectedMessage{state.last_stamp.value_or(last_stamp_), sensor, state.topic + ": " + reason};
  }

  const LiveSourceOptions options_;
  const std::atomic<bool>& stop_;
  idl::Participant participant_;
  idl::Publications publications_;

  mutable std::mutex mutex_;  // guards inputs_, queue_ and end_wanted_, and info_ where another thread looks at it
  std::condition_variable filled_;
  std::vector<Input> inputs_;
  std::deque<Arrival> queue_;
  std::size_t queued_memory_ = 0;
  common::RecordingInfo info_;
  std::optional<std::string> end_wanted_;

  // of the thread that calls prepare() and next()
  std::deque<Arrival> backlog_;
  std::size_t backlog_memory_ = 0;
  SensorDiscovery discovery_;
  std::map<std::string, common::Pose2> T_child_base_;
  StampGuard stamps_;
  common::Nanoseconds last_stamp_ = 0;
  std::optional<std::string> restart_;

  std::vector<std::jthread> threads_;  // last: they end before what they use
};

Result<std::unique_ptr<LiveSource>> LiveSource::create(const idl::Participant& participant,
                                                       const LiveSourceOptions& options,
                                                       const std::atomic<bool>& stop) {
  auto publications = idl::Publications::create(participant);
  if (!publications) return tl::unexpected(publications.error());
  auto impl = std::make_unique<Impl>(options, stop, participant, *std::move(publications));
  if (auto listening = impl->listen(); !listening) return tl::unexpected(listening.error());
  return std::unique_ptr<LiveSource>(new LiveSource(std::move(impl)));
}

LiveSource::LiveSource(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LiveSource::~LiveSource() = default;

Result<void> LiveSource::prepare(const std::function<void(const std::string&)>& tell) { return impl_->prepare(tell); }
const common::RecordingInfo& LiveSource::info() const { return impl_->info(); }
Result<std::optional<common::RecordingItem>> LiveSource::next() { return impl_->next(); }
std::optional<std::string> LiveSource::restart_wanted() { return impl_->restart_wanted(); }
void LiveSource::end_session(const std::string& reason) { impl_->end_session(reason); }
std::vector<InputState> LiveSource::inputs() const { return impl_->inputs(); }

}  // namespace slamfuse::service
