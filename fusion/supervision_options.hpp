// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"

namespace slamfuse::fusion {

/// When the fused pose is withheld, and how often a half is told where it is.
struct SupervisionOptions {
  double lost_position_sigma = 0.5;
  double lost_heading_sigma = 0.35;
  double both_lost_after = 0.5;
  double visual_only_after = 1.0;
  double help_after = 1.0;
  double contradiction_time = 5.0;
  double probation = 6.0;
  bool visual_scale_drifts = false;
  double command_interval = 5.0;
  double status_interval = 1.0;

  void describe(common::OptionVisitor& visit) {
    visit.real("lost_position_sigma", lost_position_sigma, {0.01, 100.0}, "m",
               "With no half left, the fused pose is LOST when its position is less certain than this.");
    visit.real("lost_heading_sigma", lost_heading_sigma, {0.01, 3.15}, "rad",
               "With no half left, the fused pose is LOST when its heading is less certain than this.");
    visit.real(
        "both_lost_after", both_lost_after, {0.0, 60.0}, "s",
        "The fused pose is LOST when for this long every half that speaks has called itself lost, or one has and the "
        "other tracks somewhere else; until then it is SUSPECT.");
    visit.real("visual_only_after", visual_only_after, {0.0, 60.0}, "s",
               "Without a word of a laser for this long the visual map frame becomes the map frame.");
    visit.real(
        "help_after", help_after, {0.0, 60.0}, "s",
        "A half that calls itself lost is told its pose after this time, in which the other one has to track on: "
        "after a carry it may take a moment longer to notice. One that sees no feature for this long does not keep "
        "the fused pose from being LOST.");
    visit.real("contradiction_time", contradiction_time, {0.1, 600.0}, "s",
               "A half that still claims to track is told its pose after the other half has overruled it this long.");
    visit.real(
        "probation", probation, {0.0, 600.0}, "s",
        "A half that is told its pose is not used for this long while the other one tracks: it may have mapped "
        "what was wrong, and follow that again. Longer than contradiction_time, so that one that claims to track "
        "all the same can be told again before. With visual_scale_drifts there is no probation.");
    visit.flag("visual_scale_drifts", visual_scale_drifts,
               "The visual poses come without a scale of their own (the program knows it of our visual half "
               "without wheel odometry, and takes it for granted of another system's poses). While such a half tracks, "
               "what contradicts the laser is a bent map and not a wrong place, "
               "so it is not told its pose: that would tear its map apart.");
    visit.real("command_interval", command_interval, {0.1, 600.0}, "s", "A half is told its pose at most this often.");
    visit.real("status_interval", status_interval, {0.05, 60.0}, "s", "Status rows are written at least this often.");
  }
};

}  // namespace slamfuse::fusion
