// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/calibration.hpp"
#include "common/pose3.hpp"
#include "common/sensor_message.hpp"
#include "idl/message.hpp"
#include "service/ros_conversion.hpp"

namespace slamfuse::service {

/// A frame and where it stands in the header's frame.
struct ChildFrame {
  std::string name;
  common::Pose3 T_parent_child;
};

/// Sensor messages as a driver of ROS 2 would publish them; ros_to_sensor.hpp is the way back. The header tells stamp
/// and frame.

/// A scan of that laser: +inf saw nothing, NaN is no measurement (REP 117); time_increment from the sweep duration.
idl::Message<idl::LaserScan> to_ros_scan(const RosHeader& header, const common::LaserScan& scan,
                                         const common::LaserCalibration& laser);
/// A picture in mono8.
idl::Message<idl::Image> to_ros_image(const RosHeader& header, const common::Image& image);
/// Pinhole and plumb_bob distortion. The readout time of a rolling shutter has no field and is lost.
idl::Message<idl::CameraInfo> to_ros_camera_info(const RosHeader& header, const common::CameraCalibration& camera);
/// The header's frame is that of the odometry, `base_frame` the robot's. Covariances are 0: unknown.
idl::Message<idl::Odometry> to_ros_odometry(const RosHeader& header, const std::string& base_frame,
                                            const common::WheelOdometry& odometry);
idl::Message<idl::Imu> to_ros_imu(const RosHeader& header, const common::Imu& imu);
/// All children in one message.
idl::Message<idl::TFMessage> to_ros_transforms(const RosHeader& header, const std::vector<ChildFrame>& children);

}  // namespace slamfuse::service
