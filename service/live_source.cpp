// SPDX-License-Identifier: BSD-3-Clause
#include "service/live_source.hpp"

#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/ros_conversions.hpp"
#include "idl/publications.hpp"
#include "service/calibration_guard.hpp"
#include "service/clock_now.hpp"
#include "service/live_decoder.hpp"
#include "service/live_inbox.hpp"
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
/// For the transform that tells where a sensor is mounted: what publishes it may be started last, and what is assumed
/// without it stays.
constexpr auto kTransformPatience = 3s;

}  // namespace

class LiveSource::Impl {
 public:
  Impl(const LiveSourceOptions& options, const std::atomic<bool>& stop, const idl::Participant& participant,
       idl::Publications publications)
      : options_(options),
        stop_(stop),
        inbox_(options.inbox, participant, std::move(publications)),
        discovery_(options.base_frame),
        odometry_(options.odometry) {
    info_.path = "DDS";
    info_.format = "dds";
  }

  Result<void> listen() { return inbox_.listen(); }

  Result<void> prepare(const std::function<void(const std::string&)>& tell) {
    auto report = Clock::now() + kReport;
    while (!stop_) {
      if (auto arrival = inbox_.take(kNap)) {
        learn(*arrival);
        backlog_.push_back(std::move(*arrival));
        trim_backlog();
      }
      const auto now = Clock::now();
      const bool complete = has_settled(now);
      const std::string missing = missing_sensors();
      if (missing.empty() && complete) {
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
      std::optional<LiveArrival> arrival;
      if (backlog_.empty()) {
        arrival = inbox_.take(kNap);
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

  std::optional<std::string> restart_wanted() {
    if (restart_) {
      decide();
      take_end_wanted();  // one that came while the session was ending is met by its end
    }
    return std::exchange(restart_, std::nullopt);
  }

  void dropped(const std::string& sensor) { inbox_.dropped(sensor); }

  const common::RecordingInfo& info() const { return info_; }

  std::vector<InputState> inputs() const {
    std::vector<InputState> states = inbox_.inputs();
    const std::lock_guard lock(mutex_);
    for (InputState& state : states) {
      state.in_use = state.sensor.empty() || info_.sensors.contains(state.sensor);
      if (const auto problem = problems_.find(state.sensor); problem != problems_.end()) {
        state.problem = problem->second;
      }
    }
    return states;
  }

 private:
  std::optional<std::string> take_end_wanted() {
    const std::lock_guard lock(mutex_);
    return std::exchange(end_wanted_, std::nullopt);
  }

  // ---- finding out what there is

  /// What arrived before everything is known waits, as far as there is room: the oldest goes.
  void trim_backlog() {
    backlog_memory_ += backlog_.back().memory;
    while (backlog_.size() > options_.inbox.queue_capacity || backlog_memory_ > options_.inbox.queue_memory) {
      inbox_.dropped(backlog_.front().input);
      backlog_memory_ -= backlog_.front().memory;
      backlog_.pop_front();
    }
  }

  void learn(const LiveArrival& arrival) {
    const std::string sensor = inbox_.sensor_of(arrival.input);
    std::visit([&](const auto& message) { discovery_.hear(sensor, *message); }, arrival.payload);
    // A transform may concern any of them.
    const std::set<std::string> concerned = sensor.empty() ? discovery_.usable_sensors() : std::set{sensor};
    const std::lock_guard lock(mutex_);
    for (const std::string& known : concerned) problems_[known] = discovery_.problem_of(known);
  }

  bool all_named() const { return !options_.inbox.topics.empty(); }

  /// Whether neither another sensor nor a transform that tells where one is mounted is to be waited for any more: since
  /// a sensor became usable for the last time, it has had its time to come.
  bool has_settled(Clock::time_point now) {
    const std::size_t usable = discovery_.usable_sensors().size();
    if (usable != usable_) last_appearance_ = now;
    usable_ = usable;
    const Clock::duration since = now - last_appearance_;
    if (!discovery_.unmounted().empty()) return since >= kTransformPatience;
    return all_named() || since >= std::chrono::duration<double>(options_.settle);
  }

  /// In words; empty when it can start.
  std::string missing_sensors() const {
    std::vector<std::string> missing;
    std::set<SensorKind> kinds;
    for (const InputState& state : inbox_.topics()) {
      if (state.sensor.empty()) continue;
      const bool heard = discovery_.usable(state.sensor);
      const SensorKind kind = *kind_of_sensor(state.sensor);
      if (heard) kinds.insert(kind);
      // Another system may be started again, or for the first time, when it pleases; one of them is enough to begin.
      if (!state.required || heard || kind == SensorKind::kPose) continue;
      const std::string problem = discovery_.problem_of(state.sensor);
      missing.push_back(
          fmt::format("{} on {}{}", state.sensor, state.topic, problem.empty() ? std::string() : " (" + problem + ")"));
    }
    const auto none = [&kinds](SensorKind kind) { return !kinds.contains(kind); };
    if (missing.empty() && !all_named()) {
      if (options_.needs_laser && none(SensorKind::kLaser)) missing.emplace_back("a laser");
      if (options_.needs_camera && none(SensorKind::kCamera)) missing.emplace_back("a calibrated camera");
    }
    if (!missing.empty()) return fmt::format("{}", fmt::join(missing, ", "));
    const bool blind = none(SensorKind::kLaser) && none(SensorKind::kCamera) && none(SensorKind::kPose);
    return blind ? std::string("a laser, a calibrated camera or poses of another system") : std::string();
  }

  /// Takes what has been found out as what this recording is.
  void decide() {
    common::RecordingInfo info;
    info.path = info_.path;
    info.format = info_.format;
    discovery_.describe(info);
    for (const auto& [camera, readout] : options_.readout) {
      const auto found = info.calibration.cameras.find(camera);
      if (found != info.calibration.cameras.end()) found->second.readout = readout;
    }
    for (const auto& [sensor, about] : info.sensors) {
      if (about.kind == SensorKind::kOdometry || about.kind == SensorKind::kPose)
        decoder_.set_child_frame(sensor, discovery_.T_child_base(sensor));
    }
    for (const auto& [sensor, topic] : options_.inbox.topics) {
      if (kind_of_sensor(sensor) == SensorKind::kPose)
        info.sensors[sensor].kind = SensorKind::kPose;  // it may come yet
    }
    // What is rejected before the first good message still happened about then, not in 1970.
    if (last_stamp_ == 0) last_stamp_ = discovery_.newest_stamp();
    const std::lock_guard lock(mutex_);
    info_ = std::move(info);
  }

  // ---- messages

  std::optional<common::RecordingItem> to_item(const LiveArrival& arrival) {
    const std::string sensor = inbox_.sensor_of(arrival.input);
    if (!info_.sensors.contains(sensor)) {
      meet_latecomer(arrival);
      return std::nullopt;
    }
    if (const auto* info = std::get_if<idl::Message<idl::CameraInfo>>(&arrival.payload)) {
      return check_camera(arrival, sensor, **info);
    }
    if (calibrations_.doubts(sensor)) {
      return doubt(arrival, sensor, "its camera_info tells another calibration than before");
    }
    meet_late(arrival, sensor);
    auto message = decoder_.decode(arrival.payload, sensor);
    if (!message) return reject(arrival, sensor, message.error().message);
    if (auto* pose = std::get_if<common::ExternalPose>(&*message)) pose->publisher = arrival.publisher;
    if (const auto* odometry = std::get_if<common::WheelOdometry>(&*message)) {
      if (const auto flaw = odometry_.flaw_of(*odometry, arrival.at)) return reject(arrival, sensor, *flaw);
    }
    const common::Nanoseconds stamp = common::stamp_of(*message);
    const auto verdict = stamps_.judge(sensor, stamp, arrival.at);
    if (verdict.kind == StampGuard::Kind::kRefused) return reject(arrival, sensor, verdict.reason);
    if (verdict.kind == StampGuard::Kind::kSteppedBack) {
      stamps_.reset();
      odometry_.reset();
      restart_ = verdict.reason;
      return reject(arrival, sensor, verdict.reason);
    }
    last_stamp_ = stamp;
    inbox_.used(arrival.input, stamp, clock_now() - stamp);
    return common::RecordingItem(std::move(*message));
  }

  /// Learns from transforms and from sensors that take no part yet. Those that could take part do so in a session of
  /// their own, once nothing new has appeared for a while.
  void meet_latecomer(const LiveArrival& arrival) {
    learn(arrival);
    if (!has_settled(arrival.at)) return;
    std::vector<std::string> latecomers;
    for (const std::string& usable : discovery_.usable_sensors()) {
      if (!info_.sensors.contains(usable)) latecomers.push_back(usable);
    }
    if (latecomers.empty()) return;
    restart_ = fmt::format("{} can take part now", fmt::join(latecomers, ", "));
  }

  /// Learns whose pose another system tells that was not heard before it all began.
  void meet_late(const LiveArrival& arrival, const std::string& sensor) {
    if (info_.sensors.at(sensor).kind != SensorKind::kPose || decoder_.knows_child_frame(sensor)) return;
    learn(arrival);
    if (discovery_.usable(sensor)) decoder_.set_child_frame(sensor, discovery_.T_child_base(sensor));
  }

  /// A calibration cannot change under way: another one is told, and begins a session of its own when it stays.
  std::optional<common::RecordingItem> check_camera(const LiveArrival& arrival, const std::string& sensor,
                                                    const idl::CameraInfo& message) {
    const auto info = from_ros(message);
    if (!info) return reject(arrival, sensor, info.error().message);
    if (const auto usable = common::camera_calibration_of(*info, {}); !usable) {
      return reject(arrival, sensor, usable.error().message);
    }
    if (calibrations_.judge(sensor, discovery_.camera_info(sensor), *info, arrival.at)) return std::nullopt;
    return doubt(arrival, sensor, "it tells another calibration than before");
  }

  /// Rejects a message of a camera whose calibration is in doubt; takes those that cameras insist on.
  common::RecordingItem doubt(const LiveArrival& arrival, const std::string& sensor, const std::string& reason) {
    std::vector<std::string> changed;
    for (const auto& [camera, info] : calibrations_.take_insisted(arrival.at)) {
      discovery_.replace(camera, info);
      changed.push_back(camera);
    }
    if (!changed.empty()) restart_ = fmt::format("the calibration of {} changed", fmt::join(changed, ", "));
    return reject(arrival, sensor, reason);
  }

  common::RecordingItem reject(const LiveArrival& arrival, const std::string& sensor, const std::string& reason) {
    const InputState state = inbox_.rejected(arrival.input, reason);
    return common::RejectedMessage{state.last_stamp.value_or(last_stamp_), sensor, state.topic + ": " + reason};
  }

  const LiveSourceOptions options_;
  const std::atomic<bool>& stop_;
  LiveInbox inbox_;

  mutable std::mutex mutex_;  // guards end_wanted_, problems_, and info_ where another thread looks at it
  common::RecordingInfo info_;
  std::optional<std::string> end_wanted_;
  std::map<std::string, std::string> problems_;  // by sensor, why it cannot be used

  // of the thread that calls prepare() and next()
  std::deque<LiveArrival> backlog_;
  std::size_t backlog_memory_ = 0;
  SensorDiscovery discovery_;
  LiveDecoder decoder_{info_};
  StampGuard stamps_;
  CalibrationGuard calibrations_;
  OdometryGuard odometry_;
  std::size_t usable_ = 0;             // sensors
  Clock::time_point last_appearance_;  // of one of them
  common::Nanoseconds last_stamp_ = 0;
  std::optional<std::string> restart_;
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
void LiveSource::dropped(const std::string& sensor) { impl_->dropped(sensor); }
std::vector<InputState> LiveSource::inputs() const { return impl_->inputs(); }

}  // namespace slamfuse::service
