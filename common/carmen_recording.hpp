// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "common/error.hpp"
#include "common/recording.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::common {

/// Whether the beginning of a file reads as a CARMEN log: one of its lines starts with a CARMEN message.
bool is_carmen_log(std::string_view beginning);

/// Opens a CARMEN log (plain, gzip, bzip2) with FLASER or ROBOTLASER1 messages of a front laser. The file is read
/// through once here. Messages come in file order, which is the true order, with the scans' own ipc stamps, which may
/// repeat and step back: every scan gives a WheelOdometry ("odom0") and a LaserScan ("laser0") of equal stamp. See
/// common/RECORDINGS.md for what is taken from where. Errors (kInvalidInput): unreadable, no scan.
Result<std::unique_ptr<Recording>> open_carmen_recording(const std::filesystem::path& path);

/// The reference `NAME.reference.txt` beside the log `NAME.clf.bz2` (see carmen_reference.hpp) as poses of base_link;
/// empty when there is no such file. It is sparse: compare at equal stamps. Errors: those of the log and of the
/// reference.
Result<Trajectory2> read_carmen_ground_truth(const std::filesystem::path& path);

}  // namespace slamfuse::common
