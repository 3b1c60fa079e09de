// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

namespace slamfuse::visual_slam {

/// Which measurements of an image agree with the prediction and with each other.
struct Consensus {
  std::vector<int> accepted;  ///< indices, rising
  double mean_nis = 0.0;      ///< joint normalised innovation squared per degree of freedom of the accepted ones
};

/// Chooses among measurements of two numbers each by their innovations z - h(x) and the joint innovation covariance
/// S = H P H^T + R (both stacked).
///
/// 1. Gate: a measurement alone must pass the chi-square test (seed 001 section 3, step 3).
/// 2. 1-point consensus (Civera et al. 2010, not in the seeds): each measurement in turn is believed; what it implies
///    for the others follows from S alone, nu_j|i = nu_j - S_ji S_ii^-1 nu_i. The one most others agree with wins. All
///    are tried instead of a random few: it costs little and needs no random numbers.
/// 3. Joint compatibility: going from the best agreeing to the worst, a measurement is accepted when it passes the test
///    given all accepted before it.
Consensus find_consensus(const Eigen::VectorXd& innovation, const Eigen::MatrixXd& covariance, double gate);

/// The chi-square quantile of two degrees of freedom, -2 ln(1 - probability).
double chi_square_gate_2(double probability);

}  // namespace slamfuse::visual_slam
