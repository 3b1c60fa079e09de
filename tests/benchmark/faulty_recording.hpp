// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/recording.hpp"

namespace slamfuse {

/// What becomes of a sensor's messages.
enum class FaultKind {
  kSilenced,  ///< none come
  kFrozen,    ///< the last one before the fault comes again and again, with the stamps of the true ones
  kReplaced,  ///< they are of another recording, those of the same time since its start, with the true stamps
};

/// "silenced", "frozen", "of another recording".
std::string to_string(FaultKind kind);

struct SensorFault {
  FaultKind kind = FaultKind::kSilenced;
  std::vector<std::string> sensors;  ///< beginnings of their names, e.g. "laser", "cam"
  double from = 0.0;                 ///< [s] from the recording's start
  double to = 0.0;                   ///< [s]
};

/// The recording with the fault. `donor` is what kReplaced takes from, null else: a camera's pictures are those of its
/// camera of the same name or its first one, of a laser's scans the beams nearest in bearing are taken.
std::unique_ptr<common::Recording> with_fault(std::unique_ptr<common::Recording> recording, SensorFault fault,
                                              std::unique_ptr<common::Recording> donor);

/// The recording as if the time from `from` to `to` [s from its start] had not been: its messages are left out, later
/// ones come that much earlier.
std::unique_ptr<common::Recording> without_time(std::unique_ptr<common::Recording> recording, double from, double to);

}  // namespace slamfuse
