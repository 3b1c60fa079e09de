// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/calibration.hpp"
#include "common/recording.hpp"
#include "common/sensor_message.hpp"

namespace foreign {

/// Sensor messages as CDR, written with eProsima's library from the ROS 2 definitions: nothing of idl/ takes part.
std::vector<char> scan_message(const slamfuse::common::LaserScan& scan,
                               const slamfuse::common::LaserCalibration& laser);
std::vector<char> image_message(const slamfuse::common::Image& image);
std::vector<char> camera_info_message(const std::string& camera, slamfuse::common::Nanoseconds stamp,
                                      const slamfuse::common::CameraCalibration& calibration);
std::vector<char> odometry_message(const slamfuse::common::WheelOdometry& odometry);
std::vector<char> mountings_message(const slamfuse::common::Calibration& calibration);

/// What `serve` publishes, as one line of text each: "pose STAMP FRAME x y sin cos variance", "tf STAMP FRAME CHILD x
/// y", "map FRAME width height resolution x y occupied free", "status STAMP state score sources", "landmarks FRAME
/// points x y z" (of the first).
std::string read_pose(std::vector<char>& message);
std::string read_transform(std::vector<char>& message);
std::string read_map(std::vector<char>& message);
std::string read_status(std::vector<char>& message);
std::string read_landmarks(std::vector<char>& message);

}  // namespace foreign
