// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"

namespace slamfuse::laser_slam {

/// Settings of the LoopDetector.
struct LoopDetectorOptions {
  double min_path = 10.0;
  double enter_share = 0.25;
  double leave_share = 0.1;

  void describe(common::OptionVisitor& visit) {
    visit.real("min_path", min_path, {0.5, 1000.0}, "m",
               "A surface last seen this much travel ago is old; also the least travel between two loop closures.");
    visit.real("enter_share", enter_share, {0.05, 1.0}, "",
               "A loop is closed when this share of the beams meets old surfaces.");
    visit.real("leave_share", leave_share, {0.0, 1.0}, "", "Old ground is left when the share falls below this.");
  }
};

}  // namespace slamfuse::laser_slam
