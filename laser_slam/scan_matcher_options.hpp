// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"

namespace slamfuse::laser_slam {

/// Settings of scan matching against a GridMap.
struct ScanMatcherOptions {
  double sigma = 0.02;
  int kernel_cells = 2;
  double outlier_probability = 0.05;
  double unknown_likelihood = 0.5;
  int max_iterations = 12;
  int max_beams = 360;
  double rematch_agreement = 0.6;
  double rematch_gain = 0.3;
  double search_distance = 0.6;
  double search_angle = 0.5;

  void describe(common::OptionVisitor& visit) {
    visit.real("sigma", sigma, {0.001, 0.5}, "m", "Standard deviation of an endpoint across the mapped surface.");
    visit.integer("kernel_cells", kernel_cells, {1, 4}, "cells",
                  "Reach of the kernel that weighs the cells around an endpoint into a local surface.");
    visit.real("outlier_probability", outlier_probability, {1e-6, 0.9}, "",
               "Likelihood of an endpoint that meets no surface, relative to a perfect one.");
    visit.real("unknown_likelihood", unknown_likelihood, {1e-6, 1.0}, "",
               "Likelihood of an endpoint in unknown space, relative to a perfect one.");
    visit.integer("max_iterations", max_iterations, {1, 100}, "", "Gauss-Newton steps at most.");
    visit.integer("max_beams", max_beams, {10, 100000}, "", "Beams used; denser scans are thinned evenly.");
    visit.real("rematch_agreement", rematch_agreement, {0.0, 1.0}, "",
               "Below this agreement other starts and a search around the prediction are tried.");
    visit.real("rematch_gain", rematch_gain, {0.0, 5.0}, "nat/beam",
               "How much likelier a beam must be on average to follow the match away from the odometry.");
    visit.real("search_distance", search_distance, {0.0, 5.0}, "m", "Half-width of that search.");
    visit.real("search_angle", search_angle, {0.0, 3.2}, "rad", "Half-width of that search in heading.");
  }
};

}  // namespace slamfuse::laser_slam
