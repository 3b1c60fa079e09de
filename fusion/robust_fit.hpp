// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/options.hpp"
#include "fusion/planar_affine.hpp"
#include "fusion/trajectory_pairing.hpp"

namespace slamfuse::fusion {

struct RobustFitOptions {
  int hypotheses = 300;
  int scored_pairs = 400;
  int iterations = 30;
  double inlier_sigmas = 3.0;
  int seed = 1;

  void describe(common::OptionVisitor& visit) {
    visit.integer("hypotheses", hypotheses, {10, 100000}, "", "Random minimal samples tried.");
    visit.integer("scored_pairs", scored_pairs, {20, 100000}, "",
                  "Pairs, evenly spread, on which each hypothesis is scored.");
    visit.integer("iterations", iterations, {1, 1000}, "", "Most iterations of the reweighted least squares.");
    visit.real("inlier_sigmas", inlier_sigmas, {1.0, 10.0}, "",
               "A pair whose residual is within this many robust standard deviations is an inlier.");
    visit.integer("seed", seed, {0, 2147483647}, "", "Of the random samples.");
  }
};

/// Which maps a robust fit may choose from.
enum class RobustModel {
  kRigid,       ///< three parameters, scale 1
  kSimilarity,  ///< four parameters
  kAffine,      ///< six parameters, positive determinant
};

/// A robust fit of laser = map * visual.
struct RobustFit {
  PlanarAffine map;
  /// Covariance of the six numbers (linear row by row, then translation), inflated for residuals that are correlated
  /// in time.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double sigma = 0.0;         ///< robust standard deviation of a residual's coordinate [m]
  std::vector<bool> inliers;  ///< by pair
  double loss = 0.0;  ///< mean over the scored pairs of the residual's square, cut off at the inlier bound [m^2]
  /// The same for the best map whose rotation differs by more than `runner_up_separation`.
  double runner_up_loss = 0.0;
};

/// Random sample consensus (least quantile of squares, so no noise level need be known), then iterated least squares
/// with Tukey's weights. Deterministic in the pairs and the seed. Returns nothing where no sample gives a map, e.g.
/// fewer than three pairs or points that coincide. `runner_up_separation` in radians.
std::optional<RobustFit> fit_robust(const std::vector<PosePair>& pairs, RobustModel model,
                                    const RobustFitOptions& options, double runner_up_separation);

}  // namespace slamfuse::fusion
