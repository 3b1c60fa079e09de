// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/calibration.hpp"
#include "common/error.hpp"
#include "common/image_decoder.hpp"
#include "common/ros_messages.hpp"
#include "common/sensor_message.hpp"

namespace slamfuse::common {

/// A laser's geometry as a scan states it, with `sweep_duration` from its time_increment (0 = not told). Error, the
/// reason alone: an impossible geometry.
Result<LaserCalibration> laser_calibration_of(const RosLaserScan& scan, const Pose3& T_base_laser);
/// A scan of that laser. Ranges by REP 117 and as_range(): NaN, -inf, 0 and what is nearer than range_min is no
/// measurement, +inf and what is beyond range_max saw nothing. Error, the reason alone: another geometry.
Result<LaserScan> to_laser_scan(const RosLaserScan& scan, const std::string& sensor, const LaserCalibration& laser);

/// A pinhole camera with plumb_bob distortion. Error, the reason alone: not calibrated, another model.
Result<CameraCalibration> camera_calibration_of(const RosCameraInfo& info, const Pose3& T_base_camera);
/// The picture in gray: mono8, 8UC1 as they are, colours by their luma. Error, the reason alone: another encoding, not
/// of the expected size, fewer data than that takes.
Result<GrayImage> to_gray(const RosImage& image, ImageSize expected);

}  // namespace slamfuse::common
