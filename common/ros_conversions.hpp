// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/calibration.hpp"
#include "common/error.hpp"
#include "common/image_decoder.hpp"
#include "common/pose2.hpp"
#include "common/pose3.hpp"
#include "common/ros_messages.hpp"
#include "common/sensor_message.hpp"

namespace slamfuse::common {

/// How long a sweep takes by the scan's time_increment [s]; 0 = not told, or impossible.
double stated_sweep(const RosLaserScan& scan);
/// Whether a scan goes (nearly) all the way round.
bool is_full_circle(const RosLaserScan& scan);

/// A laser's geometry as a scan states it. `sweep_duration` is the stated one, but 0 for a laser that looks all the way
/// round: their heads mostly turn clockwise, drivers turn the ranges round and leave the time_increment positive, so
/// the order of firing is not known. Error, the reason alone: an impossible geometry.
Result<LaserCalibration> laser_calibration_of(const RosLaserScan& scan, const Pose3& T_base_laser);
/// A scan of that laser. Ranges by REP 117 and as_range(): NaN, -inf, 0 and what is nearer than range_min is no
/// measurement, +inf and what is beyond range_max saw nothing. Error, the reason alone: another geometry.
Result<LaserScan> to_laser_scan(const RosLaserScan& scan, const std::string& sensor, const LaserCalibration& laser);

/// Odometry of base_link, from that of the frame whose pose is told.
WheelOdometry to_wheel_odometry(const RosOdometry& odometry, const std::string& sensor, const Pose2& T_child_base);

/// How a camera looks whose mounting is not told: T_base_camera forward, level (REP 103), at base_link.
Pose3 looking_forward();
/// A pinhole camera with plumb_bob distortion. Error, the reason alone: not calibrated, another model.
Result<CameraCalibration> camera_calibration_of(const RosCameraInfo& info, const Pose3& T_base_camera);
/// Whether to_gray() takes images of an encoding.
bool is_gray_or_colour(const std::string& encoding);
/// The picture in gray: mono8, 8UC1 as they are, colours by their luma. Error, the reason alone: another encoding, not
/// of the expected size, fewer data than that takes.
Result<GrayImage> to_gray(const RosImage& image, ImageSize expected);

}  // namespace slamfuse::common
