// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "laser_slam/beam_model.hpp"
#include "laser_slam/likelihood_field.hpp"
#include "laser_slam/localization_options.hpp"
#include "laser_slam/place_scores.hpp"

namespace slamfuse::laser_slam {

/// A pose from which a scan could have been made.
struct PoseCandidate {
  common::Pose2 pose;
  double log_likelihood = 0.0;  ///< of all beams, BeamModel::traced_log_likelihood()
};

/// Searches a whole map for the poses that explain a scan: correlative scan matching from coarse to fine (Olson, ICRA
/// 2009) over the likelihood field.
///
/// 1. Coarse: every free place on a grid of `step`, with headings `step_angle` apart, is scored with few beams and a
///    likelihood that forgives `step`: the field's distances change by no more than the pose is moved (PlaceScores).
/// 2. Rough: the best `kept_share` of them climbs with the same few beams in steps of `step` / 2. Of those that meet
///    only the best stays.
/// 3. Fine: the best of these climb with all beams given, in steps halved from `step` / 2 to 1/8 of it.
/// 4. Beams that go through walls are counted. Of poses close together only the best stays.
class PoseSearch {
 public:
  /// The field must outlive this.
  PoseSearch(const LikelihoodField& field, const BeamModelOptions& model, const PoseSearchOptions& options);

  /// The most likely distinct poses for beam ends given in base_link, of a laser at `mount` there, best first. Empty
  /// for a map without free space.
  std::vector<PoseCandidate> search(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& mount) const;

 private:
  std::vector<PoseCandidate> coarse(const std::vector<Eigen::Vector2d>& points) const;
  PoseCandidate climb(const std::vector<Eigen::Vector2d>& points, const common::Pose2& start, int levels) const;

  const LikelihoodField* field_;
  PoseSearchOptions options_;
  BeamModel fine_model_;
  PlaceScores places_;
};

/// Evenly chosen `most` of the points; all when there are no more.
std::vector<Eigen::Vector2d> thin_points(const std::vector<Eigen::Vector2d>& points, int most);

}  // namespace slamfuse::laser_slam
