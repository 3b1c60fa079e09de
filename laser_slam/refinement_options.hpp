// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"

namespace slamfuse::laser_slam {

/// Settings of the refinement of the path in hindsight, see refine_path().
struct RefinementOptions {
  bool enabled = true;
  int submap_scans = 20;
  int rounds = 3;
  double reach = 3.0;
  int submaps_per_scan = 3;
  double least_agreement = 0.55;
  double search_agreement = 0.7;
  double loop_outlier = 3.0;

  void describe(common::OptionVisitor& visit) {
    visit.flag("enabled", enabled,
               "Refine the final path and map when a run ends; off: both are those of the best particle.");
    visit.integer("submap_scans", submap_scans, {4, 1000}, "", "Scans in a submap; each scan is in two of them.");
    visit.integer("rounds", rounds, {1, 20}, "", "How often loops are looked for and the path is adjusted to them.");
    visit.real("reach", reach, {0.1, 50.0}, "m",
               "A scan is compared with submaps that were drawn at most so far from where it was made.");
    visit.integer("submaps_per_scan", submaps_per_scan, {1, 100}, "", "With how many of them at most.");
    visit.real("least_agreement", least_agreement, {0.0, 1.0}, "",
               "Agreement a scan must have with them to be a loop.");
    visit.real("search_agreement", search_agreement, {0.0, 1.0}, "",
               "The same where it was looked for around, in the window of the scan matcher.");
    visit.real("loop_outlier", loop_outlier, {0.1, 1000.0}, "sigma",
               "Loops that miss by more than this count less and less (Cauchy's loss).");
  }
};

}  // namespace slamfuse::laser_slam
