// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "common/options.hpp"
#include "common/pose_estimate.hpp"
#include "fusion/alignment.hpp"
#include "fusion/uncertain_pose.hpp"

namespace slamfuse::fusion {

/// How far a half's own covariance is believed.
struct MeasurementOptions {
  double smallest_position_sigma = 0.01;
  double smallest_heading_sigma = 0.005;
  double uncertain_inflation = 3.0;

  void describe(common::OptionVisitor& visit) {
    visit.real("smallest_position_sigma", smallest_position_sigma, {1e-4, 1.0}, "m",
               "Added in quadrature to a pose's own standard deviation of the position.");
    visit.real("smallest_heading_sigma", smallest_heading_sigma, {1e-5, 1.0}, "rad",
               "Added in quadrature to a pose's own standard deviation of the heading.");
    visit.real("uncertain_inflation", uncertain_inflation, {1.0, 100.0}, "",
               "Factor on the standard deviations of a pose whose source calls itself uncertain.");
  }
};

/// Why an estimate cannot be used at all: a number that is not finite, a covariance that is none, a source that is
/// neither laser nor visual. Nothing when it can.
std::optional<std::string> flaw_of(const common::PoseEstimate& estimate);

/// The estimate in its own map frame with the covariance the filter takes: widened when uncertain, never below the
/// floors.
UncertainPose measurement_of(const common::PoseEstimate& estimate, const MeasurementOptions& options);

/// A visual measurement brought into the laser map frame: G_LV moves pose and covariance. What G_LV itself is off by is
/// not in it.
UncertainPose aligned_pose(const UncertainPose& visual, const Alignment& alignment);

/// Covariance of what an aligned pose at the place `visual` is off by: what pairs that G_LV had not seen were off by
/// (the bend of the visual map, which G_LV cannot follow; the larger of the held-out and the forward error), and G_LV's
/// own uncertainty there; more where a scale had to be fitted.
Eigen::Matrix3d alignment_error(const Alignment& alignment, const Eigen::Vector2d& visual);

/// The inverse of aligned_pose.
UncertainPose visual_pose(const UncertainPose& aligned, const Alignment& alignment);

}  // namespace slamfuse::fusion
