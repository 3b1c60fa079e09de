// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "common/options.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::fusion {

/// How what lies between the two sensors is looked for, and when it counts.
struct SensorOffsetOptions {
  bool estimate = true;
  double most_clock_offset = 0.6;
  double significance = 3.0;
  double smallest_clock_offset = 0.01;
  double smallest_lever_arm = 0.02;
  int samples = 600;

  void describe(common::OptionVisitor& visit) {
    visit.flag(
        "estimate", estimate,
        "Whether the difference of the two sensors' clocks and the lever arm between the tracked points are looked "
        "for, and used where the pairs clearly show them.");
    visit.real("most_clock_offset", most_clock_offset, {0.0, 5.0}, "s", "Clock offsets are looked for up to this.");
    visit.real("significance", significance, {1.0, 20.0}, "",
               "An offset is used only if it is this many of its standard deviations away from zero.");
    visit.real("smallest_clock_offset", smallest_clock_offset, {0.0, 1.0}, "s", "Smaller clock offsets are let be.");
    visit.real("smallest_lever_arm", smallest_lever_arm, {0.0, 10.0}, "m", "Shorter lever arms are let be.");
    visit.integer("samples", samples, {50, 100000}, "", "Visual poses, evenly spread, that are used.");
  }
};

/// What lies between two sensors that tell of one drive, found from their trajectories alone.
struct SensorOffsets {
  /// Laser stamps minus visual stamps of one moment [s]: what has to be added to a visual stamp.
  double clock_offset = 0.0;
  double clock_sigma = 0.0;                               ///< its standard deviation [s]
  Eigen::Vector2d lever_arm = Eigen::Vector2d::Zero();    ///< the visual's tracked point in the laser's body frame [m]
  Eigen::Vector2d lever_sigma = Eigen::Vector2d::Zero();  ///< standard deviations [m]
  double yaw = 0.0;                                       ///< of the visual's body in the laser's body frame [rad]
  double yaw_sigma = 0.0;                                 ///< [rad]
  double rmse = 0.0;  ///< of the positions with all of them estimated, over the inliers [m]
};

/// Estimates clock offset, lever arm and yaw together with the similarity between the two map frames. The clock offset
/// is first searched where the turns of the two bodies over half a second agree best (turns need neither alignment nor
/// scale); then all eight numbers are refined by Gauss-Newton on
///
///     p_L(t + d) + R(theta_L(t + d)) l = s R p_V(t) + T,     theta_L(t + d) + yaw = theta_V(t) + phi
///
/// with Tukey's weights, L interpolated between neighbours at most `max_gap` apart (phi, the rotation of the maps, is
/// that of the similarity). Standard deviations from the information matrix, inflated for residuals that are correlated
/// in time. Returns nothing where the trajectories do not fix them: too few poses in common, or hardly a turn.
std::optional<SensorOffsets> estimate_sensor_offsets(const common::Trajectory2& laser,
                                                     const common::Trajectory2& visual, common::Nanoseconds max_gap,
                                                     const SensorOffsetOptions& options);

/// Only what is significant, the rest zero; nothing where nothing is.
std::optional<SensorOffsets> significant(const SensorOffsets& offsets, const SensorOffsetOptions& options);

/// In words with figures, e.g. for a warning that the configuration disagrees.
std::string describe(const SensorOffsets& offsets);

}  // namespace slamfuse::fusion
