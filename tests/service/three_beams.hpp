// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/calibration.hpp"

namespace slamfuse::service {

/// A laser of three beams [rad], [m], as small as a scan in a test can be.
inline common::LaserCalibration three_beams() {
  common::LaserCalibration laser;
  laser.angle_min = -1.0;
  laser.angle_increment = 1.0;
  laser.beams = 3;
  laser.range_min = 0.1;
  laser.range_max = 5.0;
  return laser;
}

}  // namespace slamfuse::service
