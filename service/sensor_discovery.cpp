// SPDX-License-Identifier: BSD-3-Clause
#include "service/sensor_discovery.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "common/ros_conversions.hpp"
#include "service/external_poses.hpp"

namespace slamfuse::service {

using common::SensorKind;

namespace {

/// No robot has more; a sender that makes up ever new ones shall not fill the memory.
constexpr std::size_t kMostFrames = 2000;

/// Where a sensor is taken to be mounted when tf does not tell.
common::Pose3 assumed_mounting(SensorKind kind) {
  return kind == SensorKind::kCamera ? common::looking_forward() : common::Pose3{};
}

std::string in_words(SensorKind kind) {
  return kind == SensorKind::kCamera ? "at the same place, looking forward" : "at the same place";
}

/// Whether two mountings differ by rounding at most.
bool is_same(const common::Pose3& one, const common::Pose3& other) {
  constexpr double kRounding = 1e-6;  // [m] and [rad]
  return (one.translation - other.translation).norm() < kRounding &&
         one.rotation.angularDistance(other.rotation) < kRounding;
}

}  // namespace

std::optional<SensorKind> kind_of_sensor(const std::string& name) {
  if (name == kLaserPose || name == kVisualPose) return SensorKind::kPose;
  if (name.starts_with("laser")) return SensorKind::kLaser;
  if (name.starts_with("cam")) return SensorKind::kCamera;
  if (name.starts_with("odom")) return SensorKind::kOdometry;
  return std::nullopt;
}

void SensorDiscovery::use(Heard& heard, const common::RosHeader& header) {
  heard.frame = header.frame;
  newest_stamp_ = std::max(newest_stamp_, header.stamp);
}

void SensorDiscovery::hear(const std::string& sensor, const idl::LaserScan& scan) {
  Heard& heard = heard_[sensor];
  auto read = from_ros(scan);
  const auto usable = read ? common::laser_calibration_of(*read, {}) : tl::unexpected(read.error());
  if (!usable) return void(heard.problem = usable.error().message);
  use(heard, read->header);
  heard.scan = *std::move(read);
}

void SensorDiscovery::hear(const std::string& sensor, const idl::CameraInfo& info) {
  Heard& heard = heard_[sensor];
  auto read = from_ros(info);
  const auto usable = read ? common::camera_calibration_of(*read, {}) : tl::unexpected(read.error());
  if (!usable) return void(heard.problem = usable.error().message);
  use(heard, read->header);
  heard.camera = *std::move(read);
}

void SensorDiscovery::hear(const std::string& sensor, const idl::Odometry& odometry) {
  Heard& heard = heard_[sensor];
  if (kind_of_sensor(sensor) == SensorKind::kPose) return hear_pose(heard, pose_from_ros(odometry));
  const auto read = from_ros(odometry);
  if (!read) return void(heard.problem = read.error().message);
  use(heard, read->header);
  heard.frame = read->child_frame;
  heard.message = true;
}

void SensorDiscovery::hear(const std::string& sensor, const idl::PoseWithCovarianceStamped& pose) {
  hear_pose(heard_[sensor], from_ros(pose));
}

void SensorDiscovery::hear(const std::string& sensor, const idl::PoseStamped& pose) {
  hear_pose(heard_[sensor], from_ros(pose));
}

void SensorDiscovery::hear_pose(Heard& heard, const common::Result<RosPose>& pose) {
  if (!pose) return void(heard.problem = pose.error().message);
  use(heard, pose->header);
  heard.frame = pose->child_frame.empty() ? base_frame_ : pose->child_frame;
  heard.message = true;
}

void SensorDiscovery::hear(const std::string& sensor, const idl::Image& /*image*/) { heard_[sensor].message = true; }

void SensorDiscovery::hear(const std::string& sensor, const idl::CompressedImage& /*image*/) {
  heard_[sensor].message = true;
}

void SensorDiscovery::hear(const std::string& /*sensor*/, const idl::TFMessage& transforms) {
  const auto read = from_ros(transforms);
  if (!read) return;
  for (const auto& transform : *read) {
    if (frames_.size() == kMostFrames) return;
    frames_.add(transform.header.frame, transform.child_frame, transform.pose);
  }
}

void SensorDiscovery::replace(const std::string& camera, common::RosCameraInfo info) {
  Heard& heard = heard_.at(camera);
  use(heard, info.header);
  heard.camera = std::move(info);
}

bool SensorDiscovery::usable(const std::string& sensor) const {
  const auto found = heard_.find(sensor);
  if (found == heard_.end()) return false;
  const Heard& heard = found->second;
  switch (*kind_of_sensor(sensor)) {
    case SensorKind::kLaser:
      return heard.scan.has_value();
    case SensorKind::kCamera:
      return heard.camera.has_value() && heard.message;
    default:
      return heard.message;
  }
}

std::set<std::string> SensorDiscovery::usable_sensors() const {
  std::set<std::string> sensors;
  for (const auto& [sensor, heard] : heard_) {
    if (usable(sensor)) sensors.insert(sensor);
  }
  return sensors;
}

std::set<std::string> SensorDiscovery::unmounted() const {
  std::set<std::string> sensors = usable_sensors();
  std::erase_if(sensors,
                [this](const auto& sensor) { return heard_.at(sensor).assumed || told_mounting(sensor).has_value(); });
  return sensors;
}

std::string SensorDiscovery::problem_of(const std::string& sensor) const {
  const auto found = heard_.find(sensor);
  if (found == heard_.end()) return {};
  const Heard& heard = found->second;
  if (usable(sensor)) return heard.assumed && told_mounting(sensor) ? note_on_mounting(sensor) : std::string();
  if (!heard.problem.empty() || kind_of_sensor(sensor) != SensorKind::kCamera) return heard.problem;
  return heard.message ? "no camera_info was heard of it" : "no picture was heard of it";
}

void SensorDiscovery::describe(common::RecordingInfo& info) {
  for (const std::string& sensor : usable_sensors()) {
    const Heard& heard = heard_.at(sensor);
    const SensorKind kind = *kind_of_sensor(sensor);
    const common::Pose3 mounted = mounting(sensor);
    info.sensors[sensor].kind = kind;
    if (kind == SensorKind::kLaser) {
      info.calibration.lasers[sensor] = *common::laser_calibration_of(*heard.scan, mounted);
    } else if (kind == SensorKind::kCamera) {
      info.calibration.cameras[sensor] = *common::camera_calibration_of(*heard.camera, mounted);
    }
    if (const std::string note = note_on_mounting(sensor); !note.empty()) {
      info.notes.push_back(fmt::format("{}: {}", sensor, note));
    }
  }
}

std::optional<common::Pose3> SensorDiscovery::told_mounting(const std::string& sensor) const {
  const std::string& frame = heard_.at(sensor).frame;
  if (frame == base_frame_) return common::Pose3{};
  const SensorKind kind = *kind_of_sensor(sensor);
  if (kind == SensorKind::kLaser || kind == SensorKind::kCamera) return frames_.transform(base_frame_, frame);
  const auto T_child_base = frames_.transform(frame, base_frame_);
  if (!T_child_base) return std::nullopt;
  return common::to_pose3(common::to_pose2(*T_child_base));
}

common::Pose3 SensorDiscovery::mounting(const std::string& sensor) {
  Heard& heard = heard_.at(sensor);
  const auto told = told_mounting(sensor);
  heard.assumed |= !told;
  return heard.assumed ? assumed_mounting(*kind_of_sensor(sensor)) : *told;
}

std::string SensorDiscovery::note_on_mounting(const std::string& sensor) const {
  const Heard& heard = heard_.at(sensor);
  if (!heard.assumed) return {};
  const SensorKind kind = *kind_of_sensor(sensor);
  const auto told = told_mounting(sensor);
  if (!told) {
    return fmt::format("no transform between {} and {} was heard, taken to be {}", base_frame_,
                       heard.frame.empty() ? "a frame that is not told" : heard.frame, in_words(kind));
  }
  if (is_same(*told, assumed_mounting(kind))) return {};
  return fmt::format("the transform between {} and {} came too late: taken to be {} until the service is started again",
                     base_frame_, heard.frame, in_words(kind));
}

common::Pose2 SensorDiscovery::T_child_base(const std::string& odometry) {
  return common::to_pose2(mounting(odometry));
}

const common::RosCameraInfo& SensorDiscovery::camera_info(const std::string& camera) const {
  return *heard_.at(camera).camera;
}

}  // namespace slamfuse::service
