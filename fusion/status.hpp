// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/pose_estimate.hpp"
#include "common/time.hpp"

namespace slamfuse::fusion {

/// The fusion's own verdict on a half or on the fused pose.
enum class Verdict {
  kTracking,  ///< to be trusted
  kSuspect,   ///< something disagrees; the reasons say what
  kLost,      ///< not to be used
};

/// "TRACKING", "SUSPECT", "LOST".
std::string to_string(Verdict verdict);

/// One row of status.csv.
struct StatusEntry {
  common::Nanoseconds stamp = 0;
  common::PoseSource source = common::PoseSource::kFused;  ///< kLaser, kVisual or kFused
  Verdict state = Verdict::kTracking;
  double score = 1.0;                ///< 0 (worthless) .. 1 (everything agrees)
  std::vector<std::string> reasons;  ///< in words, empty when all is well
};

}  // namespace slamfuse::fusion
