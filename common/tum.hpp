// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "common/error.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::common {

/// Reads a trajectory: TUM text `timestamp x y z qx qy qz qw` (seconds, metres) or planar `timestamp x y theta` (theta
/// in radians, read as a pose at z = 0). Lines that start with '#' are comments. Poses stay in the order of the lines,
/// whatever their stamps; stamps keep every digit down to nanoseconds.
///
/// Errors (kInvalidInput, naming file and line): the file cannot be read or has no pose, a line has another number of
/// columns than 8 or 4 or than the lines before, a column is not a finite number, a quaternion's length is off 1 by
/// more than 1e-3 (a smaller error is rounding and is normalised away).
Result<Trajectory3> read_trajectory(const std::filesystem::path& path);

/// TUM text, one line a pose in the given order: stamps and positions with nine decimals, quaternions with twelve.
std::string to_tum(const Trajectory3& trajectory);
std::string to_tum(const Trajectory2& trajectory);

/// Writes to_tum() to a file. Errors (kFailed): the file cannot be written, with the system's reason.
Result<void> write_tum(const std::filesystem::path& path, const Trajectory3& trajectory);
Result<void> write_tum(const std::filesystem::path& path, const Trajectory2& trajectory);

}  // namespace slamfuse::common
