// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "common/trajectory.hpp"
#include "fusion/alignment_options.hpp"
#include "fusion/mapping_matrix.hpp"
#include "fusion/planar_affine.hpp"
#include "fusion/sensor_offsets.hpp"

namespace slamfuse::fusion {

/// The verdict on two trajectories and the map between their frames: metrics.json's "alignment".
struct Alignment {
  bool accepted = false;
  std::string reason;                                     ///< in words, with the figures that decided
  AlignmentMethod method = AlignmentMethod::kSimilarity;  ///< the one used; never kAuto after an accepted run

  MappingMatrix mapping;  ///< G_LV and its factors, visual map frame to laser map frame
  PlanarAffine map;       ///< what G_LV does in the plane
  /// Covariance of `map` (linear row by row, then translation); zero for seed004, which has none.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector2d scale = Eigen::Vector2d::Ones();  ///< laser metres per visual unit along x and y, see AffineParts
  bool scale_along_laser_axes = false;              ///< whose x and y axes: the laser's, else the visual's
  double mean_scale = 1.0;                          ///< for heights
  double scale_sigma = 0.0;                         ///< standard deviation of mean_scale; NaN without a covariance
  double rotation_deg = 0.0;                        ///< from the visual to the laser map frame
  /// What is added to a visual heading [rad]; the circular median over the pairs. Differs from the rotation where the
  /// two trajectories are of bodies turned against each other.
  double heading_offset = 0.0;
  double heading_rmse = 0.0;  ///< of the inlying pairs' headings after that [rad]

  /// What was found to lie between the two sensors, with standard deviations; used or not.
  std::optional<SensorOffsets> offsets;
  double clock_offset = 0.0;  ///< what is added to visual stamps [s]: as estimated where it is clear, else 0
  /// The visual's tracked point in the laser's body frame [m]: as estimated where it is clear, else 0. `map` meets that
  /// point.
  Eigen::Vector2d lever_arm = Eigen::Vector2d::Zero();

  double rmse = 0.0;          ///< of the inlying pairs' positions [m]
  double heldout_rmse = 0.0;  ///< of the inliers that were held out, under a fit to the others [m]
  double forward_rmse = 0.0;  ///< of the last quarter of the pairs, under a fit to those before [m], by the median
  double rmse_all = 0.0;      ///< of all pairs, outliers too [m]
  std::size_t pairs = 0;      ///< used: without those in which the robot stood still
  std::size_t inliers = 0;
  double runner_up_ratio = 0.0;     ///< loss of the best well-separated other angle over the best loss
  double straightness_ratio = 0.0;  ///< narrow over wide standard deviation of the laser's positions
  bool essential_applied = false;   ///< seed004: whether T_ess is more than the identity
  std::string essential_report;     ///< seed004: why

  /// Covariance of `map * visual` that comes from the map's own uncertainty; it grows away from the pairs.
  Eigen::Matrix2d position_covariance(const Eigen::Vector2d& visual) const;
  /// A pose of the visual map frame in the laser map frame, of the laser's tracked point.
  common::Pose2 to_laser(const common::Pose2& visual) const;
  /// A pose of the laser map frame in the visual map frame, of the visual's tracked point.
  common::Pose2 to_visual(const common::Pose2& laser) const;
};

/// What is known of the scale of a visual trajectory.
enum class VisualScale {
  kUnknown,  ///< any, and it may drift
  kMetric,   ///< metres, as far as wheel odometry tells
};

/// Aligns two trajectories of the same drive. Pure: same input, options and seed give the same bytes. Trajectories need
/// not be sorted; a pose that is not finite refuses the alignment. When refused, `reason` says why and the other fields
/// hold what was found before (for a look, not for use).
Alignment align_trajectories(const common::Trajectory2& laser, const common::Trajectory2& visual,
                             const AlignmentOptions& options, VisualScale scale = VisualScale::kUnknown);

/// Median distance [m] of the paired positions under an alignment: how well it fits a typical pair of these
/// trajectories, whichever it was made from. Infinite without pairs.
double typical_error(const common::Trajectory2& laser, const common::Trajectory2& visual, const Alignment& alignment,
                     const AlignmentOptions& options);

/// The visual trajectory in the laser map frame and by the laser's clock: the content of visual_aligned.tum.
common::Trajectory2 to_laser_frame(const common::Trajectory2& visual, const Alignment& alignment);

}  // namespace slamfuse::fusion
