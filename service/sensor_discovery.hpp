// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>

#include "common/frame_tree.hpp"
#include "common/pose2.hpp"
#include "common/recording.hpp"
#include "common/ros_messages.hpp"
#include "idl/messages.hpp"
#include "service/ros_to_sensor.hpp"

namespace slamfuse::service {

/// The kind of a sensor by its name (laser0, odom0, cam0, laser_pose, visual_pose); nothing for other names.
std::optional<common::SensorKind> kind_of_sensor(const std::string& name);

/// Finds out from the first messages of a robot's topics which sensors there are, how they are built and where they are
/// mounted on `base_frame`.
class SensorDiscovery {
 public:
  explicit SensorDiscovery(std::string base_frame) : base_frame_(std::move(base_frame)) {}

  /// Learns from a message of this sensor. One that cannot be used leaves a problem.
  void hear(const std::string& sensor, const idl::LaserScan& scan);
  void hear(const std::string& sensor, const idl::CameraInfo& info);
  void hear(const std::string& sensor, const idl::Odometry& odometry);
  void hear(const std::string& sensor, const idl::Image& image);
  void hear(const std::string& sensor, const idl::CompressedImage& image);
  void hear(const std::string& sensor, const idl::PoseWithCovarianceStamped& pose);
  void hear(const std::string& sensor, const idl::PoseStamped& pose);
  /// Learns where frames are; belongs to no sensor. Transforms that cannot be used tell nothing.
  void hear(const std::string& sensor, const idl::TFMessage& transforms);

  /// A usable camera tells another calibration, which is usable too.
  void replace(const std::string& camera, common::RosCameraInfo info);

  /// Whether all is known of a sensor but where it is mounted.
  bool usable(const std::string& sensor) const;
  std::set<std::string> usable_sensors() const;
  /// The usable sensors of which tf does not tell where they are mounted, and nothing was assumed yet.
  std::set<std::string> unmounted() const;
  /// Why what was heard of a sensor cannot be used, or what is missing of a camera; of one that can be used, that it is
  /// mounted elsewhere than was assumed. Else empty, as when nothing was heard.
  std::string problem_of(const std::string& sensor) const;

  /// Writes the usable sensors with their calibration into `info`, and a note for each mounting that tf does not tell:
  /// such a sensor is taken to be at base_frame, a camera looking forward. There it stays whatever tf tells later: maps
  /// are made of what it sees from there.
  void describe(common::RecordingInfo& info);
  /// From the frame whose pose this odometry, or external pose, tells to base_frame; the identity, from then on, where
  /// tf does not tell.
  common::Pose2 T_child_base(const std::string& odometry);
  /// The calibration a usable camera told.
  const common::RosCameraInfo& camera_info(const std::string& camera) const;
  /// The newest stamp of the messages that tell of sensors; 0 before the first.
  common::Nanoseconds newest_stamp() const { return newest_stamp_; }

 private:
  struct Heard {
    std::optional<common::RosLaserScan> scan;
    std::optional<common::RosCameraInfo> camera;
    std::string frame;     // of the sensor, or of the odometry's child
    bool message = false;  // one with data
    bool assumed = false;  // where it is mounted
    std::string problem;
  };

  /// Where tf says that a sensor is mounted, T_base_sensor; of odometry and poses T_child_base in the plane.
  std::optional<common::Pose3> told_mounting(const std::string& sensor) const;
  /// Where it is taken to be mounted; what has to be assumed is kept.
  common::Pose3 mounting(const std::string& sensor);
  /// That its mounting was assumed, or that tf told another one too late; empty if there is nothing to say.
  std::string note_on_mounting(const std::string& sensor) const;
  void use(Heard& heard, const common::RosHeader& header);
  void hear_pose(Heard& heard, const common::Result<RosPose>& pose);

  std::string base_frame_;
  std::map<std::string, Heard> heard_;
  common::FrameTree frames_;
  common::Nanoseconds newest_stamp_ = 0;
};

}  // namespace slamfuse::service
