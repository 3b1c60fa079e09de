// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace slamfuse::idl {

/// The DDS name of a ROS 2 topic: "scan" and "/scan" are "rt/scan".
inline std::string dds_topic_name(const std::string& ros_name) {
  return ros_name.starts_with('/') ? "rt" + ros_name : "rt/" + ros_name;
}

}  // namespace slamfuse::idl
