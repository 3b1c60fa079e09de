// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "common/calibration.hpp"
#include "common/error.hpp"
#include "common/sensor_message.hpp"
#include "common/stamped_csv.hpp"

namespace slamfuse::common {

/// One kind of row of an EuRoC/ASL `data.csv` each, made into a message of the named sensor. Errors (kInvalidInput)
/// tell the value and what is allowed, not the file and line: the caller knows them.

/// `x [m], y [m], theta [rad]` and perhaps `v [m/s], omega [rad/s]`.
Result<SensorMessage> read_odometry_row(const StampedRow& row, const std::string& sensor);

/// As many ranges [m] as the laser has beams; 0 = no return.
Result<SensorMessage> read_laser_row(const StampedRow& row, const std::string& sensor, const LaserCalibration& laser);

/// The name of an image file in `folder`, which is read and decoded here.
Result<SensorMessage> read_camera_row(const StampedRow& row, const std::string& sensor, const CameraCalibration& camera,
                                      const std::filesystem::path& folder);

/// Angular velocity [rad/s], then specific force [m/s^2].
Result<SensorMessage> read_imu_row(const StampedRow& row, const std::string& sensor);

}  // namespace slamfuse::common
