// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/error.hpp"
#include "common/recording.hpp"

namespace slamfuse::common {

/// Sets `info.first_stamp` and `info.last_stamp` from the sensors that have messages. Error (kInvalidInput): no sensor
/// has a message, or two sensors have no time in common.
Result<void> set_time_span(RecordingInfo& info);

}  // namespace slamfuse::common
