// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "common/error.hpp"
#include "common/recording.hpp"

namespace slamfuse::common {

/// Whether the (decompressed) beginning of a file reads as an MRPT rawlog: the head of a serialised action collection,
/// sensory frame or observation.
bool is_rawlog(std::string_view beginning);

/// Opens an MRPT rawlog, plain or gzip, in the action/observation or the observation-only format. The file is read
/// through once here. Planar range scans come as "laser0", "laser1", ... in the order in which their labels appear,
/// odometry as "odom0"; all else (images, inertial units, GPS, ...) is left alone. Messages come in file order, the
/// stamps of each sensor rising (what does not is rejected). Where the data is damaged or ends early
/// nothing behind can be found again, so the last message is then a RejectedMessage that says so. See
/// common/RECORDINGS.md for the conversions. Errors (kInvalidInput): unreadable, no scan and no odometry.
Result<std::unique_ptr<Recording>> open_rawlog_recording(const std::filesystem::path& path);

}  // namespace slamfuse::common
