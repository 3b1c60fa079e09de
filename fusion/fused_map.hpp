// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "common/landmark.hpp"
#include "common/occupancy_grid.hpp"
#include "common/options.hpp"
#include "fusion/alignment.hpp"

namespace slamfuse::fusion {

/// The visual landmarks in the laser map frame: positions through G_LV, heights by its mean scale, covariances by the
/// same map plus the covariance of the alignment itself (its last term is zero for method seed004, which has none).
std::vector<common::Landmark> to_laser_frame(const std::vector<common::Landmark>& landmarks,
                                             const Alignment& alignment);

struct MapAgreementOptions {
  double min_height = 0.1;
  double max_height = 2.0;
  int occupied = 65;

  void describe(common::OptionVisitor& visit) {
    visit.real("min_height", min_height, {-10.0, 10.0}, "m", "Lower landmarks (floor) are not compared.");
    visit.real("max_height", max_height, {-10.0, 10.0}, "m", "Higher landmarks (ceiling) are not compared.");
    visit.integer("occupied", occupied, {1, 100}, "%", "A cell at least this occupied counts as an obstacle.");
  }
};

/// How well the two maps lie on each other.
struct MapAgreement {
  std::size_t landmarks = 0;     ///< compared: within the heights
  double median_distance = 0.0;  ///< [m] from a landmark to the centre of the nearest occupied cell
  double distance_90 = 0.0;      ///< [m], 90 % are closer
};

/// Compares landmarks in the laser map frame with the grid. No landmark within the heights, or no occupied cell, gives
/// `landmarks` 0.
MapAgreement measure_agreement(const std::vector<common::Landmark>& landmarks, const common::OccupancyGrid& grid,
                               const MapAgreementOptions& options);

}  // namespace slamfuse::fusion
