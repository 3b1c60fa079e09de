// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/recording.hpp"

namespace slamfuse::service {

/// The ROS topic on which a sensor of this name and kind is heard: `scan` for laser0, `scan1` for laser1, `odom`,
/// `cam0/image_raw`, `imu0/data`, `laser_pose`.
std::string topic_of(const std::string& sensor, common::SensorKind kind);

}  // namespace slamfuse::service
