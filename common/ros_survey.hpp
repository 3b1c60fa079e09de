// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/frame_tree.hpp"
#include "common/ros_bag.hpp"
#include "common/ros_messages.hpp"
#include "common/time.hpp"

namespace slamfuse::common {

/// The kinds of messages that are read.
enum class RosType { kLaserScan, kOdometry, kImage, kCompressedImage, kCameraInfo, kPoseStamped, kTransforms, kOther };
/// The kind of a message type written as RosTopic::type has it.
RosType ros_type(const std::string& type);

/// What a bag holds of one topic.
struct RosTopicSummary {
  RosTopic topic;
  RosType type = RosType::kOther;
  std::size_t messages = 0;  ///< with a usable stamp
  std::size_t bad = 0;       ///< that cannot be decoded
  std::string first_problem;
  Nanoseconds first_stamp = 0;          ///< smallest
  Nanoseconds last_stamp = 0;           ///< largest
  std::string frame;                    ///< of the first message
  std::string child_frame;              ///< of the first odometry
  std::string encoding;                 ///< of the first image
  std::optional<RosLaserScan> scan;     ///< the first
  std::optional<RosCameraInfo> camera;  ///< the first
};

/// The fixed frame of odometry (REP 105).
inline constexpr const char* kOdometryFrame = "odom";

/// What one reading of a bag tells.
struct RosSurvey {
  std::vector<RosTopicSummary> topics;  ///< as RosBag::topics()
  FrameTree frames;
  /// The frames that tf (not tf_static) moves in kOdometryFrame, with the number and span of their stamps.
  std::map<std::string, RosTopicSummary> moved_by_tf;
};

/// Reads a bag from front to back once. Of images only the head is looked at; scans are not checked.
RosSurvey survey_ros_bag(RosBag& bag);

}  // namespace slamfuse::common
