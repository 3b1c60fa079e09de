// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "laser_slam/likelihood_field.hpp"
#include "laser_slam/localization_options.hpp"

namespace slamfuse::laser_slam {

/// Likelihood of a scan at a pose in a finished map: the likelihood field's mixture of hit, short and random
/// (Probabilistic Robotics, section 6.4), for the distance d from a beam's end to the nearest wall
///
///     p = (exp(-d^2 / 2 s^2) + e) / (1 + e),  e = short_likelihood where the beam ends in free space,
///                                             e = random_likelihood where it ends where nothing is known
///
/// Deviation: the field alone knows no ray, so "short" is told by where the beam ends instead of by its length. A beam
/// that meets a person ends in free space and costs little; one that leaves the map costs more. What a beam passes on
/// its way is looked at only by traced_log_likelihood(), which costs ten times as much: for the particles, which are
/// many and close together, the ends are enough, between places that look alike the walls in between decide.
class BeamModel {
 public:
  /// `slack` [m]: distances count less by this, which bounds the likelihood of all poses whose beams end that close.
  BeamModel(const LikelihoodField& field, const BeamModelOptions& options, double slack = 0.0);

  /// Logarithm for one beam that ends in a cell with this byte.
  float log_likelihood(LikelihoodField::Code code) const { return table_[code]; }
  /// Sum over the beam ends, given in base_link, at a pose.
  double log_likelihood(const std::vector<Eigen::Vector2d>& points, const common::Pose2& pose) const;
  /// The same, but a beam that went through a wall on its way from the laser at `mount` (base_link) is less likely by
  /// what a beam costs that ends in free space, down to one that ends where nothing is known. Less is not said, for
  /// there are walls of glass: some beams end there, others see what stands behind.
  double traced_log_likelihood(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& mount,
                               const common::Pose2& pose) const;

 private:
  const LikelihoodField* field_;
  std::array<float, 256> table_;
  double wall_in_the_way_;  // log-likelihood a beam loses by a wall it went through ...
  double nothing_;          // ... down to this
};

}  // namespace slamfuse::laser_slam
