// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/pose3.hpp"
#include "common/wire_reader.hpp"

namespace slamfuse::common {

/// How the messages of a bag are serialised.
enum class RosEncoding {
  kRos1,  ///< Ros1Reader
  kCdr,   ///< CdrReader
};

/// The messages of ROS that become sensor messages, as far as they are needed. Field by field as the definitions of
/// sensor_msgs, nav_msgs, geometry_msgs and tf2_msgs; ROS 1 and ROS 2 differ in the serialisation alone.
struct RosLaserScan {
  RosHeader header;
  float angle_min = 0.0F;
  float angle_max = 0.0F;
  float angle_increment = 0.0F;
  float time_increment = 0.0F;
  float range_min = 0.0F;
  float range_max = 0.0F;
  std::vector<float> ranges;
};

struct RosOdometry {
  RosHeader header;
  std::string child_frame;
  Pose3 pose;  ///< T_frame_child
  double forward_speed = 0.0;
  double turn_rate = 0.0;
};

struct RosPoseStamped {
  RosHeader header;
  Pose3 pose;
};

struct RosTransform {
  RosHeader header;  ///< its frame is the parent
  std::string child_frame;
  Pose3 pose;  ///< T_parent_child
};

struct RosImage {
  RosHeader header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string encoding;
  std::uint32_t step = 0;              ///< bytes a row
  std::span<const std::uint8_t> data;  ///< within the message
};

struct RosCompressedImage {
  RosHeader header;
  std::string format;
  std::span<const std::uint8_t> data;  ///< within the message
};

struct RosCameraInfo {
  RosHeader header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::vector<double> k;  ///< 9, row-major
};

/// Makes the quaternion of a pose from a message one of unit length. Error (kInvalidInput), the reason alone: the pose
/// is not finite, or its quaternion so far from that length that it is no rotation.
Result<void> normalise(Pose3& pose);

/// Decode one serialised message. Errors (kInvalidInput), the reason alone: it ends early, a length does not fit, a
/// stamp that is no time, a pose that is not finite or whose quaternion is far from unit length. What follows the
/// fields above is not looked at.
Result<RosLaserScan> decode_laser_scan(RosEncoding encoding, std::span<const std::uint8_t> message);
Result<RosOdometry> decode_odometry(RosEncoding encoding, std::span<const std::uint8_t> message);
Result<RosPoseStamped> decode_pose_stamped(RosEncoding encoding, std::span<const std::uint8_t> message);
Result<std::vector<RosTransform>> decode_transforms(RosEncoding encoding, std::span<const std::uint8_t> message);
Result<RosImage> decode_image(RosEncoding encoding, std::span<const std::uint8_t> message);
Result<RosCompressedImage> decode_compressed_image(RosEncoding encoding, std::span<const std::uint8_t> message);
Result<RosCameraInfo> decode_camera_info(RosEncoding encoding, std::span<const std::uint8_t> message);
/// The head of any message that begins with one.
Result<RosHeader> decode_header(RosEncoding encoding, std::span<const std::uint8_t> message);

}  // namespace slamfuse::common
