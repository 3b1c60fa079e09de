// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/options.hpp"
#include "fusion/mapping_matrix.hpp"
#include "fusion/trajectory_pairing.hpp"

namespace slamfuse::fusion {

struct Seed004Options {
  double image_size = 1000.0;
  double angle_step = 1.0;
  bool use_curvature_filter = true;
  double curvature_angle = 30.0;
  double curvature_min_step = 2.0;
  bool use_pyramid_filter = true;
  double pyramid_ratio = 4.0;
  bool use_essential_matrix = true;

  void describe(common::OptionVisitor& visit) {
    visit.real("image_size", image_size, {10.0, 100000.0}, "px", "Width and height of the trajectory images (w, h).");
    visit.real("angle_step", angle_step, {0.1, 10.0}, "deg", "Step of the aligned angle search; must divide 90.");
    visit.flag("use_curvature_filter", use_curvature_filter, "Run algorithm 2.");
    visit.real("curvature_angle", curvature_angle, {0.0, 180.0}, "deg",
               "Interior angle below which the following point is dropped (theta_thres).");
    visit.real("curvature_min_step", curvature_min_step, {0.0, 1000.0}, "px",
               "A shorter step has no direction: the point after it is kept.");
    visit.flag("use_pyramid_filter", use_pyramid_filter, "Run algorithm 3.");
    visit.real("pyramid_ratio", pyramid_ratio, {1.0, 1000.0}, "", "Scaling ratio r of the pyramid filter.");
    visit.flag("use_essential_matrix", use_essential_matrix,
               "Estimate T_ess; it is applied only where it lowers the residual of held-out pairs.");
  }
};

/// What the pipeline of seed 004 found.
struct Seed004Fit {
  MappingMatrix mapping;
  double loss = 0.0;               ///< algorithm 1's mean distance at the aligned angles [px]
  double runner_up_loss = 0.0;     ///< the same at the best angles whose rotation is well separated [px]
  std::size_t kept_pairs = 0;      ///< left by the curvature filter
  bool essential_applied = false;  ///< whether T_ess lowered the held-out residual
  std::string essential_report;    ///< why or why not, with the two residuals
};

/// Seed 004, section III, from the pairs to the mapping matrix. Returns nothing where a path has no extent in one
/// direction. `heldout_block` as in AlignmentOptions; `runner_up_separation` in radians.
std::optional<Seed004Fit> fit_seed004(const std::vector<PosePair>& pairs, const Seed004Options& options,
                                      int heldout_block, double runner_up_separation);

}  // namespace slamfuse::fusion
