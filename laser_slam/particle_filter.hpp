// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "laser_slam/ancestry.hpp"
#include "laser_slam/grid_map.hpp"
#include "laser_slam/random_stream.hpp"
#include "laser_slam/scan_beams.hpp"
#include "laser_slam/scan_matcher.hpp"

namespace slamfuse::laser_slam {

/// One hypothesis of the whole path and the map that follows from it.
struct Particle {
  common::Pose2 pose;         ///< T_map_base at the last update
  double log_weight = 0.0;    ///< since the last resampling, not normalised
  double log_evidence = 0.0;  ///< of the whole path: the best particle has the most
  GridMap map;
};

/// What is known of the motion since the last update, the same for all particles.
struct MotionSinceUpdate {
  common::Pose2 increment;                                   ///< by odometry (or prediction)
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of it, in the body frame at its end
  common::Pose2 guess;                                       ///< scan-matched: where the climb starts
};

/// Settings of the filter proper.
struct FilterSettings {
  int particles = 30;
  double resample_threshold = 0.5;
  double proposal_spread = 1.0;
  double lost_agreement = 0.25;  ///< a match below is not trusted: the motion model proposes
};

/// The Rao-Blackwellised particle filter of Grisetti, Stachniss and Burgard (2007): each update matches the scan in
/// every particle's own map, which gives a normal proposal (section III-B), weighs the particles by the proposal's
/// normaliser (eq. 18), resamples only when N_eff is low (section III-C), draws each pose from its proposal and draws
/// the scan into each map.
///
/// Deviations: mean, covariance and normaliser of the proposal come in closed form from the Gauss-Newton matrix at the
/// matched pose (Laplace's approximation) instead of K sampled points: smoother and K times cheaper. Because that
/// normaliser does not depend on the pose drawn, resampling comes before drawing, so children of one parent differ.
class ParticleFilter {
 public:
  /// `threads` work on the particles; they change nothing but the time.
  ParticleFilter(const FilterSettings& settings, const ScanMatcher& matcher, std::uint64_t seed, int threads);

  /// All particles at `pose` with this map and equal weights. Starts a new path.
  void start(const common::Pose2& pose, const GridMap& map);
  /// All particles drawn around `mean` in the best particle's map; the paths so far stay. Those that fall on ground not
  /// mapped start at `mean` when that is mapped: where nothing is known no scan contradicts them.
  void scatter(const common::Pose2& mean, const Eigen::Matrix3d& covariance);

  /// One step. `path_length` [m] is stamped on the map; with `map_scan` false the scan weighs but is not drawn.
  void update(const ScanBeams& scan, const MotionSinceUpdate& motion, double path_length, bool map_scan);

  const std::vector<Particle>& particles() const { return particles_; }
  const Particle& best() const { return particles_[static_cast<std::size_t>(best_)]; }
  /// Path of the best particle, one pose an update (start and scatter count).
  std::vector<common::Pose2> best_path() const { return ancestry_.path_of(best_); }
  /// N_eff before the last resampling decision.
  double effective_particles() const { return effective_; }
  /// Second moment of the weighted particles about the best one.
  Eigen::Matrix3d spread() const;

 private:
  struct Proposal {
    common::Pose2 mean;
    Eigen::Matrix3d covariance;
    double log_normalizer;
  };
  Proposal propose(const Particle& particle, const ScanBeams& scan, const MotionSinceUpdate& motion) const;
  std::vector<int> choose_parents(const std::vector<Proposal>& proposals);
  /// The particle with the most evidence, the first of equals.
  int most_evident() const;
  void record(const std::vector<int>& parents);

  FilterSettings settings_;
  ScanMatcher matcher_;
  int threads_;
  std::vector<Particle> particles_;
  std::vector<RandomStream> streams_;  // of the slots, not of the particles: children of one parent differ
  RandomStream resampling_stream_;
  std::vector<InsertionScratch> scratches_;  // of the workers
  Ancestry ancestry_;
  int best_ = 0;
  double effective_ = 0.0;
};

}  // namespace slamfuse::laser_slam
