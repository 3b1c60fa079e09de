// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "laser_slam/grid_map.hpp"
#include "laser_slam/scan_matcher_options.hpp"

namespace slamfuse::laser_slam {

/// What is believed of a pose before its scan is looked at.
struct PosePrior {
  common::Pose2 mean;                                     ///< T_map_base
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< inverse covariance of (x, y, theta), map frame
};

/// How a scan lies in a map at one pose.
struct ScanFit {
  double log_likelihood = 0.0;                            ///< sum over the beams, 0 = every beam perfect
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();     ///< of the log-likelihood by (x, y, theta)
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< Gauss-Newton approximation of its negative Hessian
  int known = 0;                                          ///< beams that ended in mapped space
  double agreement = 0.0;                                 ///< mean inlier probability of those, 0..1 (0 for none)
  double mean_last_path = 0.0;                            ///< when the met surfaces were last seen [m of path]
  double old_share = 0.0;                                 ///< share of the known beams that met an old surface
};

/// The best pose found and the fit there.
struct ScanMatch {
  common::Pose2 pose;
  ScanFit fit;
};

/// Finds the pose at which a scan lies best in a map.
///
/// Each endpoint p meets the local surface around it (GridMap::surface_at). Its distance is measured across the
/// surface, and along it only as far as the surface is no line: d^2 = (n.(p - mean))^2 + rho (t.(p - mean))^2, rho from
/// the ratio of the moments, so a bare corridor leaves its direction open. The beam's likelihood is that of GMapping
/// with an outlier floor, (exp(-d^2 / 2 sigma^2) + e) / (1 + e); unknown space has a constant one. The maximum of
/// gain * log-likelihood + prior is found by Gauss-Newton steps with the inlier probabilities as weights, starting with
/// a wide sigma (graduated non-convexity).
class ScanMatcher {
 public:
  /// `gain` tempers the likelihood against the prior, see EvidenceGain.
  ScanMatcher(const ScanMatcherOptions& options, double gain) : options_(options), gain_(gain) {}

  /// The factor that the likelihood and the information of a fit count with.
  double gain() const { return gain_; }

  /// The fit at a pose. Surfaces last seen before `old_before` [m of path] count as old.
  ScanFit evaluate(const GridMap& map, const std::vector<Eigen::Vector2d>& points, const common::Pose2& pose,
                   double old_before = 0.0) const;

  /// Climbs from `start` to the nearest maximum.
  ScanMatch match(const GridMap& map, const std::vector<Eigen::Vector2d>& points, const common::Pose2& start,
                  const PosePrior& prior, double old_before = 0.0) const;

  /// Looks over the whole search window around `center` for the pose where most endpoints meet occupied cells, then
  /// climbs from there without a prior.
  ScanMatch search(const GridMap& map, const std::vector<Eigen::Vector2d>& points, const common::Pose2& center,
                   double old_before = 0.0) const;

 private:
  ScanMatcherOptions options_;
  double gain_;
};

}  // namespace slamfuse::laser_slam
