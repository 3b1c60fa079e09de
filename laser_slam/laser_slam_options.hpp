// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "common/options.hpp"
#include "laser_slam/evidence_gain.hpp"
#include "laser_slam/localization_options.hpp"
#include "laser_slam/loop_detector_options.hpp"
#include "laser_slam/map_options.hpp"
#include "laser_slam/motion_model_options.hpp"
#include "laser_slam/refinement_options.hpp"
#include "laser_slam/scan_matcher_options.hpp"

namespace slamfuse::laser_slam {

/// Settings of LaserSlam: one set serves every robot and building measured in the README.
struct LaserSlamOptions {
  int particles = 30;
  double update_distance = 0.25;
  double update_angle = 0.35;
  double update_interval = 0.0;
  double resample_threshold = 0.5;
  double likelihood_gain = 0.05;
  double least_evidence = 9.0;
  double proposal_spread = 1.0;
  double max_range = 80.0;
  double lost_agreement = 0.25;
  double uncertain_agreement = 0.45;
  double lost_time = 2.0;
  double degenerate_ratio = 0.03;
  bool compensate_sweep = true;
  MapOptions map;
  MotionModelOptions motion;
  ScanMatcherOptions matcher;
  LoopDetectorOptions loops;
  RefinementOptions refinement;
  LocalizationOptions localization;

  /// What a beam of a sensor with so many beams (0: they vary) counts.
  double evidence_gain(int beams) const {
    return EvidenceGain{likelihood_gain, least_evidence}.of(std::min(beams, matcher.max_beams));
  }

  void describe(common::OptionVisitor& visit) {
    visit.integer("particles", particles, {1, 1000}, "", "Hypotheses of the whole path, each with its own map.");
    visit.real("update_distance", update_distance, {0.0, 10.0}, "m",
               "Travel after which a scan updates the filter and the map; scans between are only matched.");
    visit.real("update_angle", update_angle, {0.0, 3.2}, "rad", "Turn after which a scan updates the filter.");
    visit.real("update_interval", update_interval, {0.0, 3600.0}, "s",
               "Time after which a scan updates the filter though the robot stands; 0 = never.");
    visit.real("resample_threshold", resample_threshold, {0.0, 1.0}, "",
               "Resample when the effective number of particles falls below this share of them.");
    visit.real("likelihood_gain", likelihood_gain, {1e-4, 1.0}, "",
               "Share of a beam that counts as independent evidence: tempers the weights.");
    visit.real("least_evidence", least_evidence, {0.0, 1000.0}, "beams",
               "A scan counts as at least so many independent beams, as far as the sensor has them.");
    visit.real("proposal_spread", proposal_spread, {0.0, 10.0}, "",
               "Standard deviations of the proposal are multiplied by this before a particle is drawn.");
    visit.real("max_range", max_range, {0.5, 1000.0}, "m", "Returns beyond are not used, whatever the sensor allows.");
    visit.real("uncertain_agreement", uncertain_agreement, {0.0, 1.0}, "",
               "Below this agreement of the scan with the map the pose is UNCERTAIN.");
    visit.real("lost_agreement", lost_agreement, {0.0, 1.0}, "",
               "Below this agreement scans do not enter the map; the state is LOST once it lasts for lost_time.");
    visit.real("lost_time", lost_time, {0.0, 60.0}, "s", "How long the agreement must stay low to be LOST.");
    visit.real("degenerate_ratio", degenerate_ratio, {0.0, 1.0}, "",
               "A direction is open when the scan holds it by less than this share of the best held one.");
    visit.flag("compensate_sweep", compensate_sweep, "Undo the robot's motion between a scan's first and last beam.");
    visit.nested("map", map, "The grid map of each particle.");
    visit.nested("motion", motion, "Uncertainty of the motion between two scans.");
    visit.nested("matcher", matcher, "Scan matching.");
    visit.nested("loops", loops, "Recognition of places seen long ago.");
    visit.nested("refinement", refinement, "The path in hindsight.");
    visit.nested("localization", localization, "Localisation in a finished map.");
  }
};

}  // namespace slamfuse::laser_slam
