// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace slamfuse::idl {

/// The DDS name of a ROS 2 topic: "scan" and "/scan" are "rt/scan".
inline std::string dds_topic_name(const std::string& ros_name) {
  return ros_name.starts_with('/') ? "rt" + ros_name : "rt/" + ros_name;
}

/// Whether a DDS topic is one of ROS 2, not of a service or of somebody else.
inline bool is_ros_topic(const std::string& dds_name) { return dds_name.starts_with("rt/"); }

/// The ROS 2 name of such a topic, without a leading slash.
inline std::string ros_topic_name(const std::string& dds_name) { return dds_name.substr(3); }

/// The DDS type of a ROS 2 type: "sensor_msgs/msg/LaserScan" is "sensor_msgs::msg::dds_::LaserScan_".
inline std::string dds_type_name(const std::string& ros_type) {
  const std::size_t last = ros_type.rfind('/');
  if (last == std::string::npos) return ros_type + "_";
  std::string name = ros_type.substr(0, last) + "/dds_/" + ros_type.substr(last + 1) + "_";
  for (auto at = name.find('/'); at != std::string::npos; at = name.find('/')) name.replace(at, 1, "::");
  return name;
}

}  // namespace slamfuse::idl
