// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"

namespace slamfuse::laser_slam {

/// Settings of a GridMap.
struct MapOptions {
  double resolution = 0.05;
  double hit_probability = 0.7;
  double miss_probability = 0.42;
  double occupied_probability = 0.3;
  double mapping_range = 30.0;
  double free_beyond_range = 4.0;
  int max_hits = 200;

  void describe(common::OptionVisitor& visit) {
    visit.real("resolution", resolution, {0.01, 0.5}, "m", "Side of a cell.");
    visit.real("hit_probability", hit_probability, {0.51, 0.99}, "",
               "Probability that a cell is occupied when a scan's beam ends in it.");
    visit.real("miss_probability", miss_probability, {0.01, 0.49}, "",
               "Probability that a cell is occupied when beams of a scan pass through it and none ends in it.");
    visit.real("occupied_probability", occupied_probability, {0.05, 0.95}, "",
               "Cells at least this likely to be occupied are matched.");
    visit.real("mapping_range", mapping_range, {0.5, 200.0}, "m", "Beams are drawn into the map up to this range.");
    visit.real("free_beyond_range", free_beyond_range, {0.0, 100.0}, "m",
               "How far a beam without return clears the map.");
    visit.integer("max_hits", max_hits, {1, 60000}, "",
                  "The running mean of a cell's endpoints forgets older ones beyond this number.");
  }
};

}  // namespace slamfuse::laser_slam
