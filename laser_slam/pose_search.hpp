// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "laser_slam/beam_model.hpp"
#include "laser_slam/likelihood_field.hpp"
#include "laser_slam/localization_options.hpp"

namespace slamfuse::laser_slam {

/// A pose from which a scan could have been made.
struct PoseCandidate {
  common::Pose2 pose;
  double log_likelihood = 0.0;  ///< of all beams, BeamModel
};

/// Searches a whole map for the poses that explain a scan: correlative scan matching from coarse to fine (Olson, ICRA
/// 2009) over the likelihood field.
///
/// 1. Coarse: every free place on a grid of `step`, with headings `step_angle` apart, is scored with few beams and a
///    likelihood that forgives `step`: the field's distances change by no more than the pose is moved.
/// 2. Fine: the best `kept_share` of them climbs with all beams, in steps halved from `step` / 2 to 1/8 of it.
/// 3. Of poses close together only the best stays.
class PoseSearch {
 public:
  /// The field must outlive this.
  PoseSearch(const LikelihoodField& field, const BeamModelOptions& model, const PoseSearchOptions& options);

  /// The most likely distinct poses for beam ends given in base_link, best first. Empty for a map without free space.
  std::vector<PoseCandidate> search(const std::vector<Eigen::Vector2d>& points) const;

 private:
  std::vector<PoseCandidate> coarse(const std::vector<Eigen::Vector2d>& points) const;
  PoseCandidate climb(const std::vector<Eigen::Vector2d>& points, const common::Pose2& start) const;

  const LikelihoodField* field_;
  PoseSearchOptions options_;
  BeamModel fine_model_;
  BeamModel coarse_model_;
  std::vector<Eigen::Vector2d> places_;  // free places on the coarse grid [m]
};

/// Evenly chosen `most` of the points; all when there are no more.
std::vector<Eigen::Vector2d> thin_points(const std::vector<Eigen::Vector2d>& points, int most);

}  // namespace slamfuse::laser_slam
