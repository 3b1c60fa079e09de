// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "laser_slam/beam_model.hpp"
#include "laser_slam/localization_options.hpp"
#include "laser_slam/random_stream.hpp"

namespace slamfuse::laser_slam {

/// A place the robot may be, as its particles tell.
struct Hypothesis {
  int id = 0;         ///< stays with it while it lives
  double mass = 0.0;  ///< probability, of all hypotheses 1
  common::Pose2 mean;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of its particles about the mean, (x, y, theta)
  common::Pose2 best;                                    ///< its heaviest particle
  int particles = 0;
  double effective_particles = 0.0;  ///< 1 / sum w^2
};

/// The particles of Monte Carlo localisation (Dellaert, Fox, Burgard, Thrun, ICRA 1999), kept by hypothesis: each has
/// its own particles and a probability of its own.
///
/// - Motion: every particle moves by the odometry's increment and a draw of its uncertainty.
/// - Weight: w *= p(scan | pose)^gain, see BeamModel. A hypothesis' probability grows with the mean of that over its
///   particles, and shrinks by the beams that went through walls at the heaviest one: mass *= (p_traced / p)^gain sum w
///   p^gain.
/// - Resampling: systematic, within each hypothesis, when its N_eff falls below a share of its particles. The number of
///   children is Fox's (IJRR 2003, eq. 12) for the k bins its particles stand in,
///   n = (k-1)/(2 e) (1 - 2/(9(k-1)) + sqrt(2/(9(k-1))) z)^3. Because hypotheses do not take particles from each other,
///   a look-alike place dies of evidence only, never of the luck of the draw (Milstein et al., Robust Global
///   Localization Using Clustered Particle Filtering, AAAI 2002).
/// - Memory: between hypotheses old evidence fades by `memory` an update. A small steady difference between two
///   look-alike places, which may be a fault of the map, so never becomes certainty.
class HypothesisFilter {
 public:
  HypothesisFilter(const HypothesisFilterOptions& options, std::uint64_t seed);

  void clear();
  bool empty() const { return groups_.empty(); }

  /// Adds a hypothesis: particles drawn from N(mean, covariance), as many as such a spread needs but not more than
  /// `most` >= 1. `log_mass` is its probability relative to the best hypothesis', as a logarithm.
  void add(const common::Pose2& mean, const Eigen::Matrix3d& covariance, double log_mass, int most);

  /// Moves all particles by an increment with a covariance in the body frame at its end.
  void move(const common::Pose2& increment, const Eigen::Matrix3d& covariance);

  /// Weighs all particles by a scan (beam ends in base_link, of a laser at `mount` there), resamples, joins hypotheses
  /// that met and gives up those that became improbable.
  void weigh(const BeamModel& model, const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& mount);

  /// What a beam's log-likelihood counts in a scan of so many: effective_beams / beams, at most 1.
  double gain(std::size_t beams) const;

  /// All hypotheses, most probable first.
  std::vector<Hypothesis> hypotheses() const;
  int particle_count() const;

 private:
  struct Particle {
    common::Pose2 pose;
    double weight;  // within the hypothesis, sums to 1
  };
  struct Group {
    int id;
    double log_mass;  // relative to the best one's 0
    std::vector<Particle> particles;
  };

  Hypothesis describe(const Group& group) const;
  void weigh(Group& group, const BeamModel& model, const std::vector<Eigen::Vector2d>& points,
             const Eigen::Vector2d& mount);
  void resample(Group& group, int most);
  int particles_needed(const std::vector<Particle>& particles) const;
  void rank();
  void join_those_that_met();
  void give_up_improbable();

  HypothesisFilterOptions options_;
  RandomStream random_;
  int next_id_ = 0;
  std::vector<Group> groups_;  // most probable first
};

/// Fox's number of particles for `bins` occupied bins (KLD sampling), 1 for a single bin.
int kld_particles(int bins, double error, double quantile);

}  // namespace slamfuse::laser_slam
