// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include "common/error.hpp"
#include "common/image_size.hpp"
#include "common/pose2.hpp"
#include "common/recording.hpp"
#include "common/ros_messages.hpp"
#include "common/sensor_message.hpp"
#include "service/live_inbox.hpp"
#include "service/ros_to_sensor.hpp"

namespace slamfuse::service {

/// Turns the messages of a robot's topics into sensor messages, as the sensors' geometry was found to be.
class LiveDecoder {
 public:
  /// `info` is looked at with each message and must outlive this.
  explicit LiveDecoder(const common::RecordingInfo& info) : info_(info) {}

  /// Odometry, or the poses of another system, come for a frame that lies so on the robot.
  void set_child_frame(const std::string& sensor, const common::Pose2& T_child_base) {
    T_child_base_[sensor] = T_child_base;
  }
  bool knows_child_frame(const std::string& sensor) const { return T_child_base_.contains(sensor); }

  /// The message of a sensor of `info`. Error (kInvalidInput): what is wrong with it, or it is none of a sensor's.
  common::Result<common::SensorMessage> decode(const LivePayload& payload, const std::string& sensor) const;

 private:
  using Decoded = common::Result<common::SensorMessage>;

  Decoded decode(const idl::LaserScan& message, const std::string& sensor) const;
  Decoded decode(const idl::Odometry& message, const std::string& sensor) const;
  Decoded decode(const idl::Image& message, const std::string& sensor) const;
  Decoded decode(const idl::CompressedImage& message, const std::string& sensor) const;
  Decoded decode(const idl::PoseWithCovarianceStamped& message, const std::string& sensor) const;
  Decoded decode(const idl::PoseStamped& message, const std::string& sensor) const;
  static Decoded decode(const idl::CameraInfo& message, const std::string& sensor);
  static Decoded decode(const idl::TFMessage& message, const std::string& sensor);
  Decoded to_pose(const common::Result<RosPose>& pose, const std::string& sensor) const;
  common::ImageSize size_of(const std::string& camera) const;

  const common::RecordingInfo& info_;
  std::map<std::string, common::Pose2> T_child_base_;
};

}  // namespace slamfuse::service
