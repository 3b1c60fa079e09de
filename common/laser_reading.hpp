// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "common/calibration.hpp"

namespace slamfuse::common {

inline constexpr float kNoMeasurement = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kBeyondRange = std::numeric_limits<float>::infinity();

/// A raw finite reading [m] as LaserScan::ranges has it: a reading that is 0 or nearer than the laser can see is no
/// measurement (NaN), one farther than it can see is beyond range (+inf). So every finite range of a scan lies within
/// [range_min, range_max].
inline float as_range(double reading, const LaserCalibration& laser) {
  if (reading <= 0.0 || reading < laser.range_min) return kNoMeasurement;
  return reading > laser.range_max ? kBeyondRange : static_cast<float>(reading);
}

}  // namespace slamfuse::common
