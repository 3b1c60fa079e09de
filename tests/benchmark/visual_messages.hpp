// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/calibration.hpp"
#include "common/error.hpp"
#include "common/sensor_message.hpp"
#include "common/time.hpp"

namespace slamfuse {

/// What the visual half gets of a recording, read before anything is timed.
struct VisualMessages {
  std::map<std::string, common::CameraCalibration> cameras;
  std::vector<common::SensorMessage> messages;  ///< images of these cameras and wheel odometry
  common::Nanoseconds first_stamp = 0;          ///< of the recording
};

/// Reads images of the cameras in a list such as "cam0,cam1", and the wheel odometry. Errors as those of the
/// recording's reader, and a camera it does not have.
common::Result<VisualMessages> read_visual_messages(const std::filesystem::path& recording, const std::string& cameras);

/// Processor time of this process so far [ms]: unlike the clock on the wall it does not count what others do.
double processor_milliseconds();

}  // namespace slamfuse
