// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/recording.hpp"
#include "common/ros_survey.hpp"

namespace slamfuse::common {

/// A topic that is read as a sensor.
struct RosSensor {
  std::string name;  ///< "laser0", ...
  SensorKind kind = SensorKind::kLaser;
  std::size_t topic = 0;                   ///< index into RosSurvey::topics; of odometry by tf not used
  std::optional<std::size_t> camera_info;  ///< the topic of a camera's calibration
  bool by_tf = false;                      ///< odometry: from the move of `frame` in kOdometryFrame
  std::string frame;                       ///< of the sensor; of odometry the frame whose pose it tells
};

/// Which topics of a bag are read, and why not others.
struct RosTopics {
  std::vector<RosSensor> sensors;
  std::string base_frame;
  std::vector<std::string> notes;  ///< one sentence each
};

/// What the topic of compressed images has behind that of the raw ones (image_transport).
inline constexpr const char* kCompressedEnding = "/compressed";
/// The topic that tells a camera's calibration, beside the image: "camera/camera_info" for "camera/image_raw" and
/// "camera/image_raw/compressed".
std::string camera_info_topic(std::string image_topic);

/// Chooses the topics. `options.topics` names them, else:
/// - lasers: all LaserScan topics, "laser0" the first in the order: named scan, most messages, name.
/// - odometry, one only: Odometry topics in the order: named odom, frame not map, most messages, name; never one whose
///   name says that it holds the truth. Without one, the frame that tf moves in "odom" and that base_frame hangs on.
/// - cameras: Image topics of 8 bit gray or colour with a CameraInfo beside them, by name; CompressedImage where there
///   is no such Image beside it.
/// - base_frame: that of the options, else base_link, base_footprint or base if tf knows one of them, else the frame
///   the odometry moves, else base_link.
/// Errors (kUsage): options name a topic the bag does not have or of another type, or a sensor of no known kind.
Result<RosTopics> choose_ros_topics(const RosSurvey& survey, const RecordingOptions& options);

/// The topic that tells the true pose: that of the options ("truth"), else the one of type PoseStamped or Odometry
/// whose name says so (vrpn, vicon, optitrack, qualisys, mocap, truth) with most messages. Empty when there is none.
/// Errors as choose_ros_topics.
Result<std::optional<std::size_t>> choose_ros_truth(const RosSurvey& survey, const RecordingOptions& options);

}  // namespace slamfuse::common
