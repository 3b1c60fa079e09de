// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "common/error.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::common {

/// Whether a file is a reference of a corrected CARMEN log: its first line of numbers has six columns. False for what
/// cannot be read.
bool is_carmen_reference(const std::filesystem::path& path);

/// Reads the reference of a corrected CARMEN log, `raw_scan_index ipc_stamp logger_stamp x y theta` (seconds, metres,
/// radians): poses of the *laser* for some of the log's scans, in file order, with the ipc stamp. Compare them at equal
/// stamps (EvaluationOptions::max_reference_gap = 0) with sensor_trajectory(). Errors (kInvalidInput, naming file and
/// line): the file cannot be read or is empty, a line has not six finite numbers.
Result<Trajectory2> read_carmen_reference(const std::filesystem::path& path);

/// The poses of a sensor on a robot whose base_link took `base`.
Trajectory2 sensor_trajectory(const Trajectory2& base, const Pose2& T_base_sensor);

}  // namespace slamfuse::common
