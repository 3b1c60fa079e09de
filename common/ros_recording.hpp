// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "common/error.hpp"
#include "common/recording.hpp"
#include "common/ros_bag.hpp"

namespace slamfuse::common {

/// A bag as a recording. It is read through once here, then again message by message in the order of reception; the
/// stamps of each sensor rise (what does not is rejected; transforms that tf repeats are not). Which topics are which
/// sensors is told by choose_ros_topics(), the conversions by common/RECORDINGS.md. Errors: as choose_ros_topics;
/// kInvalidInput when no topic can be used.
Result<std::unique_ptr<Recording>> open_ros_recording(std::unique_ptr<RosBag> bag, const std::filesystem::path& path,
                                                      const RecordingOptions& options);

/// The poses of the topic that tells the truth, as they are: of the body that was tracked, in that system's frame.
/// Messages that cannot be read are left out. Empty when there is no such topic. Errors: as choose_ros_truth.
Result<Trajectory2> read_ros_ground_truth(RosBag& bag, const RecordingOptions& options);

}  // namespace slamfuse::common
