// SPDX-License-Identifier: BSD-3-Clause
#include "service/recording_publisher.hpp"

#include <chrono>
#include <map>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "idl/writer.hpp"
#include "service/deadline.hpp"
#include "service/ros_frames.hpp"
#include "service/sensor_to_ros.hpp"
#include "service/sensor_topic.hpp"
#include "service/unsent_messages.hpp"

namespace slamfuse::service {
struct RecordingPublisher::State {
  struct Camera {
    idl::Writer<idl::Image> image;
    idl::Writer<idl::CameraInfo> info;
  };

  common::Calibration calibration;
  idl::Participant participant;
  idl::Writer<idl::TFMessage> transform;
  idl::Writer<idl::TFMessage> mountings;
  std::map<std::string, idl::Writer<idl::LaserScan>> lasers = {};
  std::map<std::string, idl::Writer<idl::Odometry>> odometries = {};
  std::map<std::string, idl::Writer<idl::Imu>> imus = {};
  std::map<std::string, Camera> cameras = {};
  UnsentMessages unsent = {};

  template <class T>
  void send(idl::Writer<T>& writer, const idl::Message<T>& message) {
    unsent.note(writer.write(message));
  }

  template <class T>
  common::Result<void> add(std::map<std::string, idl::Writer<T>>& writers, const std::string& sensor,
                           common::SensorKind kind) {
    auto writer = idl::Writer<T>::create(participant, topic_of(sensor, kind), idl::QosProfile::kOutput);
    if (!writer) return tl::unexpected(writer.error());
    writers.emplace(sensor, *std::move(writer));
    return {};
  }

  common::Result<void> add_camera(const std::string& sensor) {
    auto image = idl::Writer<idl::Image>::create(participant, topic_of(sensor, common::SensorKind::kCamera),
                                                 idl::QosProfile::kOutput);
    if (!image) return tl::unexpected(image.error());
    auto info = idl::Writer<idl::CameraInfo>::create(participant, sensor + "/camera_info", idl::QosProfile::kOutput);
    if (!info) return tl::unexpected(info.error());
    cameras.emplace(sensor, Camera{*std::move(image), *std::move(info)});
    return {};
  }

  common::Result<void> add(const std::string& sensor, common::SensorKind kind) {
    switch (kind) {
      case common::SensorKind::kLaser:
        return add(lasers, sensor, kind);
      case common::SensorKind::kOdometry:
        return add(odometries, sensor, kind);
      case common::SensorKind::kCamera:
        return add_camera(sensor);
      case common::SensorKind::kPose:
        return {};  // no recording has one
      case common::SensorKind::kImu:
        break;
    }
    return add(imus, sensor, kind);
  }

  template <class Use>
  void for_each_sensor(const Use& use) {
    for (auto& [name, writer] : lasers) use(writer);
    for (auto& [name, writer] : odometries) use(writer);
    for (auto& [name, writer] : imus) use(writer);
    for (auto& [name, camera] : cameras) use(camera.image);
  }

  void send(const common::LaserScan& scan, common::Nanoseconds stamp) {
    send(lasers.at(scan.sensor), to_ros_scan({stamp, scan.sensor}, scan, calibration.lasers.at(scan.sensor)));
  }
  void send(const common::Image& image, common::Nanoseconds stamp) {
    Camera& camera = cameras.at(image.sensor);
    send(camera.info, to_ros_camera_info({stamp, image.sensor}, calibration.cameras.at(image.sensor)));
    send(camera.image, to_ros_image({stamp, image.sensor}, image));
  }
  void send(const common::WheelOdometry& odometry, common::Nanoseconds stamp) {
    send(odometries.at(odometry.sensor), to_ros_odometry({stamp, kOdomFrame}, kBaseFrame, odometry));
    send(transform, to_ros_transform({stamp, kOdomFrame}, kBaseFrame, odometry.pose));
  }
  void send(const common::ExternalPose& /*pose*/, common::Nanoseconds /*stamp*/) {}
  void send(const common::Imu& imu, common::Nanoseconds stamp) {
    send(imus.at(imu.sensor), to_ros_imu({stamp, imu.sensor}, imu));
  }
};

common::Result<std::unique_ptr<RecordingPublisher>> RecordingPublisher::create(const idl::Participant& participant,
                                                                               const common::RecordingInfo& info) {
  auto transform = idl::Writer<idl::TFMessage>::create(participant, "tf", idl::QosProfile::kOutput);
  if (!transform) return tl::unexpected(transform.error());
  auto mountings = idl::Writer<idl::TFMessage>::create(participant, "tf_static", idl::QosProfile::kLatchedOutput);
  if (!mountings) return tl::unexpected(mountings.error());
  auto state = std::make_unique<State>(State{.calibration = info.calibration,
                                             .participant = participant,
                                             .transform = *std::move(transform),
                                             .mountings = *std::move(mountings)});
  for (const auto& [name, sensor] : info.sensors) {
    if (auto added = state->add(name, sensor.kind); !added) return tl::unexpected(added.error());
  }
  return std::unique_ptr<RecordingPublisher>(new RecordingPublisher(std::move(state)));
}

RecordingPublisher::RecordingPublisher(std::unique_ptr<State> state) : state_(std::move(state)) {}
RecordingPublisher::~RecordingPublisher() = default;

bool RecordingPublisher::wait_for_readers(double seconds) {
  const Deadline deadline(seconds);
  bool all = true;
  state_->for_each_sensor([&](auto& writer) { all &= writer.wait_for_reader(deadline.left()); });
  return all;
}

void RecordingPublisher::introduce(common::Nanoseconds stamp) {
  std::vector<ChildFrame> children;
  for (const auto& [name, laser] : state_->calibration.lasers) children.push_back({name, laser.T_base_laser});
  for (const auto& [name, camera] : state_->calibration.cameras) children.push_back({name, camera.T_base_camera});
  state_->send(state_->mountings, to_ros_transforms({stamp, kBaseFrame}, children));
  for (auto& [name, camera] : state_->cameras) {
    state_->send(camera.info, to_ros_camera_info({stamp, name}, state_->calibration.cameras.at(name)));
  }
}

void RecordingPublisher::publish(const common::SensorMessage& message, common::Nanoseconds stamp) {
  std::visit([&](const auto& sensor_message) { state_->send(sensor_message, stamp); }, message);
}

void RecordingPublisher::finish(double seconds) {
  const Deadline deadline(seconds);
  state_->for_each_sensor([&](auto& writer) { writer.wait_for_acknowledgments(deadline.left()); });
}

const UnsentMessages& RecordingPublisher::unsent() const { return state_->unsent; }

}  // namespace slamfuse::service
