// SPDX-License-Identifier: BSD-3-Clause
#include "common/ros_recording.hpp"

#include <deque>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "common/recording_span.hpp"
#include "common/ros_conversions.hpp"
#include "common/ros_survey.hpp"
#include "common/ros_topics.hpp"

namespace slamfuse::common {
namespace {

/// A sensor being read.
struct Source {
  RosSensor sensor;
  Pose2 T_child_base;        ///< odometry: from the frame whose pose is told
  std::size_t messages = 0;  ///< of its topic so far
  std::optional<Nanoseconds> last_stamp;
};

class RosRecording final : public Recording {
 public:
  RosRecording(std::unique_ptr<RosBag> bag, RecordingInfo info, std::vector<Source> sources)
      : bag_(std::move(bag)), info_(std::move(info)), sources_(std::move(sources)) {
    std::set<std::size_t> topics;
    for (std::size_t i = 0; i < bag_->topics().size(); ++i) {
      if (!sources_of(i).empty()) topics.insert(i);
    }
    bag_->rewind(topics);
    last_stamp_ = info_.first_stamp;
    last_sensor_ = sources_.front().sensor.name;
  }

  const RecordingInfo& info() const override { return info_; }

  Result<std::optional<RecordingItem>> next() override {
    while (ready_.empty()) {
      const auto item = bag_->next();
      if (!item) return std::nullopt;
      if (const auto* damage = std::get_if<RosBagDamage>(&*item)) {
        ready_.emplace_back(RejectedMessage{last_stamp_, last_sensor_, damage->reason});
        continue;
      }
      const auto& message = std::get<RosBagMessage>(*item);
      for (Source* source : sources_of(message.topic)) read(*source, message);
    }
    RecordingItem item = std::move(ready_.front());
    ready_.pop_front();
    return item;
  }

 private:
  /// Whose messages a topic holds; several when tf is one of them.
  std::vector<Source*> sources_of(std::size_t topic) {
    const bool tf = ros_type(bag_->topics()[topic].type) == RosType::kTransforms;
    std::vector<Source*> sources;
    for (Source& source : sources_) {
      if (source.sensor.by_tf ? tf : source.sensor.topic == topic) sources.push_back(&source);
    }
    return sources;
  }

  void read(Source& source, const RosBagMessage& message) {
    ++source.messages;
    if (source.sensor.by_tf) return read_transforms(source, message);
    Result<SensorMessage> read = decode(source, message.data);
    if (!read) return reject(source, message.topic, read.error().message);
    take(source, message.topic, std::move(*read));
  }

  void read_transforms(Source& source, const RosBagMessage& message) {
    const auto transforms = decode_transforms(bag_->encoding(), message.data);
    if (!transforms) return reject(source, message.topic, transforms.error().message);
    for (const RosTransform& transform : *transforms) {
      if (transform.header.frame != kOdometryFrame || transform.child_frame != source.sensor.frame) continue;
      if (source.last_stamp == transform.header.stamp) continue;  // tf tells it again, and that is usual
      take(source, message.topic,
           WheelOdometry{transform.header.stamp, source.sensor.name, to_pose2(transform.pose) * source.T_child_base});
    }
  }

  Result<SensorMessage> decode(const Source& source, std::span<const std::uint8_t> data) const {
    const std::string& name = source.sensor.name;
    switch (source.sensor.kind) {
      case SensorKind::kLaser: {
        const auto scan = decode_laser_scan(bag_->encoding(), data);
        if (!scan) return tl::unexpected(scan.error());
        return to_laser_scan(*scan, name, info_.calibration.lasers.at(name));
      }
      case SensorKind::kOdometry: {
        const auto odometry = decode_odometry(bag_->encoding(), data);
        if (!odometry) return tl::unexpected(odometry.error());
        return to_wheel_odometry(*odometry, name, source.T_child_base);
      }
      case SensorKind::kCamera:
        return decode_camera(source, data);
      case SensorKind::kImu:
      case SensorKind::kPose:
        break;
    }
    return invalid_input("not read");
  }

  Result<SensorMessage> decode_camera(const Source& source, std::span<const std::uint8_t> data) const {
    const std::string& name = source.sensor.name;
    const CameraCalibration& camera = info_.calibration.cameras.at(name);
    const ImageSize size{camera.width, camera.height};
    RosHeader header;
    Result<GrayImage> image = invalid_input("");
    if (ros_type(bag_->topics()[source.sensor.topic].type) == RosType::kImage) {
      const auto raw = decode_image(bag_->encoding(), data);
      if (!raw) return tl::unexpected(raw.error());
      header = raw->header;
      image = to_gray(*raw, size);
    } else {
      const auto compressed = decode_compressed_image(bag_->encoding(), data);
      if (!compressed) return tl::unexpected(compressed.error());
      header = compressed->header;
      image = decode_gray_image(compressed->data, size);
    }
    if (!image) return tl::unexpected(image.error());
    return Image{header.stamp, name, camera.width, camera.height, std::move(image->pixels)};
  }

  /// Stamps of one sensor rise; a message whose stamp does not is rejected here.
  void take(Source& source, std::size_t topic, SensorMessage message) {
    const Nanoseconds stamp = stamp_of(message);
    if (source.last_stamp && stamp <= *source.last_stamp) {
      return reject(source, topic,
                    fmt::format("stamp {} {} (allowed: rising stamps)", stamp,
                                stamp == *source.last_stamp ? "repeats" : "steps back"));
    }
    source.last_stamp = last_stamp_ = stamp;
    last_sensor_ = source.sensor.name;
    ready_.emplace_back(std::move(message));
  }

  void reject(const Source& source, std::size_t topic, const std::string& problem) {
    ready_.emplace_back(RejectedMessage{source.last_stamp.value_or(last_stamp_), source.sensor.name,
                                        fmt::format("{}: message {} of {}: {}", info_.path.string(), source.messages,
                                                    bag_->topics()[topic].name, problem)});
  }

  std::unique_ptr<RosBag> bag_;
  RecordingInfo info_;
  std::vector<Source> sources_;
  std::deque<RecordingItem> ready_;
  Nanoseconds last_stamp_ = 0;
  std::string last_sensor_;
};

/// Turns the chosen topics into what RecordingInfo says, and drops those that cannot be used.
class RosSetup {
 public:
  RosSetup(const RosSurvey& survey, RosTopics topics, RecordingInfo& info)
      : survey_(survey), topics_(std::move(topics)), info_(info) {}

  Result<std::vector<Source>> prepare() {
    info_.notes = topics_.notes;
    std::vector<Source> sources;
    for (const RosSensor& sensor : topics_.sensors) {
      Source source{sensor, {}, 0, std::nullopt};
      if (const auto ready = prepare(source); !ready) {
        problem_ = fmt::format("{} cannot be used: {}", name_of(sensor), ready.error().message);
        info_.notes.push_back(problem_);
        continue;
      }
      const RosTopicSummary& summary = summary_of(sensor);
      info_.sensors[sensor.name] = {sensor.kind, summary.messages, summary.first_stamp, summary.last_stamp};
      sources.push_back(std::move(source));
    }
    tell_bad_messages();
    if (sources.empty() && !problem_.empty()) return invalid_input(info_.path.string() + ": " + problem_);
    if (sources.empty()) {
      return invalid_input(info_.path.string() + ": no topic with scans, odometry or calibrated images");
    }
    return sources;
  }

 private:
  const RosTopicSummary& summary_of(const RosSensor& sensor) const {
    return sensor.by_tf ? survey_.moved_by_tf.at(sensor.frame) : survey_.topics[sensor.topic];
  }

  std::string name_of(const RosSensor& sensor) const {
    return sensor.by_tf ? sensor.name : survey_.topics[sensor.topic].topic.name;
  }

  Result<void> prepare(Source& source) {
    const RosSensor& sensor = source.sensor;
    if (sensor.by_tf && !survey_.moved_by_tf.contains(sensor.frame)) {
      return invalid_input(fmt::format("tf moves nothing in {} that {} hangs on", kOdometryFrame, topics_.base_frame));
    }
    if (summary_of(sensor).messages == 0) {
      const std::string& problem = summary_of(sensor).first_problem;
      return invalid_input(problem.empty() ? "no message" : problem);
    }
    switch (sensor.kind) {
      case SensorKind::kLaser:
        return prepare_laser(sensor);
      case SensorKind::kCamera:
        return prepare_camera(sensor);
      case SensorKind::kOdometry:
        source.T_child_base = to_pose2(mounting(sensor.name, sensor.frame, topics_.base_frame, Pose3{}));
        return {};
      case SensorKind::kImu:
      case SensorKind::kPose:
        return {};
    }
    return {};
  }

  Result<void> prepare_laser(const RosSensor& sensor) {
    const auto laser = laser_calibration_of(*summary_of(sensor).scan,
                                            mounting(sensor.name, topics_.base_frame, sensor.frame, Pose3{}));
    if (!laser) return tl::unexpected(laser.error());
    const double stated = stated_sweep(*summary_of(sensor).scan);
    if (stated == 0.0) {
      info_.notes.push_back(
          fmt::format("{}: its messages do not tell how long a sweep takes, motion during it is not "
                      "undone (--sweep-duration)",
                      sensor.name));
    } else if (laser->sweep_duration == 0.0) {
      info_.notes.push_back(
          fmt::format("{0}: a sweep of {1:.4f} s is told, but not in which direction the laser turns, "
                      "so motion during it is not undone; --sweep-duration {0}={1:.4f} if the first "
                      "beam is fired first, {0}=-{1:.4f} if the last one is",
                      sensor.name, stated));
    }
    info_.calibration.lasers[sensor.name] = *laser;
    return {};
  }

  Result<void> prepare_camera(const RosSensor& sensor) {
    if (!sensor.camera_info) return invalid_input("no camera_info beside it");
    const auto camera =
        camera_calibration_of(*survey_.topics[*sensor.camera_info].camera,
                              mounting(sensor.name, topics_.base_frame, sensor.frame, looking_forward()));
    if (!camera) return tl::unexpected(camera.error());
    info_.calibration.cameras[sensor.name] = *camera;
    return {};
  }

  /// T_target_source by tf, else `otherwise`, which is told.
  Pose3 mounting(const std::string& sensor, const std::string& target, const std::string& source,
                 const Pose3& otherwise) {
    if (target == source) return Pose3{};
    if (const auto found = survey_.frames.transform(target, source)) return *found;
    info_.notes.push_back(
        fmt::format("{}: no transform between {} and {} in the recording, taken to be at the same "
                    "place{}",
                    sensor, target, source.empty() ? "a frame that is not told" : source,
                    otherwise.rotation.w() < 1.0 ? ", looking forward" : ""));
    return otherwise;
  }

  void tell_bad_messages() {
    for (const RosTopicSummary& summary : survey_.topics) {
      if (summary.bad == 0) continue;
      info_.notes.push_back(fmt::format("{} messages of {} cannot be read, the first: {}", summary.bad,
                                        summary.topic.name, summary.first_problem));
    }
  }

  const RosSurvey& survey_;
  RosTopics topics_;
  RecordingInfo& info_;
  std::string problem_;  ///< of the last sensor that cannot be used
};

}  // namespace

Result<std::unique_ptr<Recording>> open_ros_recording(std::unique_ptr<RosBag> bag, const std::filesystem::path& path,
                                                      const RecordingOptions& options) {
  const RosSurvey survey = survey_ros_bag(*bag);
  auto topics = choose_ros_topics(survey, options);
  if (!topics) return tl::unexpected(Error{topics.error().kind, path.string() + ": " + topics.error().message});
  RecordingInfo info;
  info.path = path;
  info.format = bag->encoding() == RosEncoding::kCdr ? "ros2" : "ros1";
  auto sources = RosSetup(survey, std::move(*topics), info).prepare();
  if (!sources) return tl::unexpected(sources.error());
  if (auto span = set_time_span(info); !span) return tl::unexpected(span.error());
  return std::make_unique<RosRecording>(std::move(bag), std::move(info), std::move(*sources));
}

Result<Trajectory2> read_ros_ground_truth(RosBag& bag, const RecordingOptions& options) {
  const auto topic = choose_ros_truth(survey_ros_bag(bag), options);
  if (!topic) return tl::unexpected(topic.error());
  Trajectory2 truth;
  if (!*topic) return truth;
  const bool is_odometry = ros_type(bag.topics()[**topic].type) == RosType::kOdometry;
  bag.rewind({**topic});
  while (const auto item = bag.next()) {
    const auto* message = std::get_if<RosBagMessage>(&*item);
    if (message == nullptr) continue;
    if (is_odometry) {
      if (const auto pose = decode_odometry(bag.encoding(), message->data)) {
        truth.push_back({pose->header.stamp, to_pose2(pose->pose)});
      }
    } else if (const auto pose = decode_pose_stamped(bag.encoding(), message->data)) {
      truth.push_back({pose->header.stamp, to_pose2(pose->pose)});
    }
  }
  return truth;
}

}  // namespace slamfuse::common
