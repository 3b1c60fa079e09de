// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

namespace slamfuse::laser_slam {

/// How much the log-likelihood of a beam counts against the motion's prior. Neighbouring beams err together (the same
/// edge of a cell, the same error of the map), so a beam is less than one independent observation; the fewer beams a
/// sensor has the farther apart they are, and the more each counts; up to four times as much, or a handful of returns
/// would overrule the odometry.
struct EvidenceGain {
  double per_beam = 0.05;                   ///< share of a beam that is independent evidence in a dense scan
  double least_evidence = 9.0;              ///< independent observations in a scan of few beams
  static constexpr double kSparsest = 4.0;  ///< of per_beam at most

  /// The factor of the log-likelihoods of a sensor of which so many beams are used, 0 when they vary.
  double of(int beams) const {
    if (beams <= 0) return per_beam;
    return std::clamp(least_evidence / static_cast<double>(beams), per_beam, kSparsest * per_beam);
  }
};

}  // namespace slamfuse::laser_slam
