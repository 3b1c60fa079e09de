// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"

namespace slamfuse::laser_slam {

/// How likely a beam is at a pose in a finished map, see BeamModel.
struct BeamModelOptions {
  double hit_sigma = 0.1;
  double short_likelihood = 0.2;
  double random_likelihood = 0.05;
  double farthest = 1.0;

  void describe(common::OptionVisitor& visit) {
    visit.real(
        "hit_sigma", hit_sigma, {0.01, 1.0}, "m",
        "Standard deviation of an endpoint's distance to the nearest wall: laser, map cells and particle spacing.");
    visit.real(
        "short_likelihood", short_likelihood, {1e-4, 1.0}, "",
        "Likelihood of a beam that ends in the map's free space (a person, a chair), relative to a perfect one.");
    visit.real("random_likelihood", random_likelihood, {1e-4, 1.0}, "",
               "Likelihood of a beam that ends where the map knows nothing, relative to a perfect one.");
    visit.real("farthest", farthest, {0.1, 10.0}, "m", "Distances to the nearest wall are not told apart beyond this.");
  }
};

/// The search of the whole map, see PoseSearch.
struct PoseSearchOptions {
  double step = 0.2;
  double step_angle = 0.105;
  int coarse_beams = 40;
  int fine_beams = 120;
  double kept_share = 0.003;
  int candidates = 30;

  void describe(common::OptionVisitor& visit) {
    visit.real("step", step, {0.05, 2.0}, "m", "Spacing of the positions tried over the free space.");
    visit.real("step_angle", step_angle, {0.01, 0.6}, "rad", "Spacing of the headings tried.");
    visit.integer("coarse_beams", coarse_beams, {8, 1000}, "", "Beams used for these.");
    visit.real("kept_share", kept_share, {1e-4, 1.0}, "", "Share of the poses tried that is refined.");
    visit.integer("fine_beams", fine_beams, {8, 100000}, "", "Beams that refine and rank these at most.");
    visit.integer("candidates", candidates, {2, 1000}, "", "Distinct poses that become hypotheses at most.");
  }
};

/// The particles, see HypothesisFilter.
struct HypothesisFilterOptions {
  int max_particles = 2000;
  int min_particles = 50;
  double kld_error = 0.05;
  double kld_quantile = 2.33;
  double bin_size = 0.1;
  double bin_angle = 0.09;
  double resample_threshold = 0.5;
  double effective_beams = 12.0;
  double memory = 0.9;
  double least_mass = 1e-4;
  double merge_distance = 0.3;
  double merge_angle = 0.25;

  void describe(common::OptionVisitor& visit) {
    visit.integer("max_particles", max_particles, {100, 1000000}, "",
                  "Particles of all hypotheses together at most, but for the min_particles that each may have.");
    visit.integer("min_particles", min_particles, {10, 10000}, "", "Particles of a hypothesis at least.");
    visit.real("kld_error", kld_error, {0.001, 1.0}, "nat",
               "Divergence from the true distribution that the number of particles of a hypothesis allows.");
    visit.real("kld_quantile", kld_quantile, {0.1, 6.0}, "",
               "That bound holds with the probability of this quantile of the standard normal distribution.");
    visit.real("bin_size", bin_size, {0.01, 5.0}, "m", "Side of the bins that are counted for it.");
    visit.real("bin_angle", bin_angle, {0.01, 1.6}, "rad", "The same in heading.");
    visit.real("resample_threshold", resample_threshold, {0.0, 1.0}, "",
               "Resample a hypothesis when its effective number of particles falls below this share of them.");
    visit.real("effective_beams", effective_beams, {0.1, 1000.0}, "",
               "Independent evidence in a scan, however many beams it has: neighbouring beams err together.");
    visit.real("memory", memory, {0.0, 1.0}, "",
               "What is left of old evidence between hypotheses at the next update: a small steady difference between "
               "two look-alike places must never become certainty.");
    visit.real("least_mass", least_mass, {0.0, 0.1}, "", "Hypotheses less probable than this are given up.");
    visit.real("merge_distance", merge_distance, {0.0, 5.0}, "m", "Hypotheses closer than this become one.");
    visit.real("merge_angle", merge_angle, {0.0, 3.2}, "rad", "The same in heading.");
  }
};

/// From what TRACKING, UNCERTAIN and LOST follow, see LocalizationMonitor.
struct LocalizationMonitorOptions {
  double good_agreement = 0.6;
  double uncertain_agreement = 0.5;
  double lost_agreement = 0.4;
  double lost_time = 1.0;
  double sure_mass = 0.95;
  double widest_spread = 0.3;
  double confirm_distance = 0.35;
  int confirm_scans = 3;

  void describe(common::OptionVisitor& visit) {
    visit.real("good_agreement", good_agreement, {0.0, 1.0}, "",
               "Share of the beams the map must explain to become TRACKING; below it the whole map is searched.");
    visit.real("uncertain_agreement", uncertain_agreement, {0.0, 1.0}, "", "Below this share TRACKING ends.");
    visit.real("lost_agreement", lost_agreement, {0.0, 1.0}, "", "Below this share for lost_time the pose is LOST.");
    visit.real("lost_time", lost_time, {0.0, 60.0}, "s", "See lost_agreement.");
    visit.real("sure_mass", sure_mass, {0.5, 1.0}, "", "Probability the best hypothesis must have for TRACKING.");
    visit.real("widest_spread", widest_spread, {0.01, 10.0}, "m",
               "Standard deviation of the best hypothesis' particles above which it is UNCERTAIN.");
    visit.real("confirm_distance", confirm_distance, {0.0, 10.0}, "m",
               "How far the same hypothesis must hold while driving (a radian of turning counts as half a metre) until "
               "a pose that was searched for is believed.");
    visit.integer("confirm_scans", confirm_scans, {1, 1000}, "",
                  "And over how many scans more at least: a fast robot drives that far between two.");
  }
};

/// Settings of LaserLocalization beyond those it shares with LaserSlam.
struct LocalizationOptions {
  double update_distance = 0.1;
  double update_angle = 0.1;
  int beams = 120;
  double explained_distance = 0.12;
  double short_weight = 0.5;
  double search_interval = 1.0;
  double newcomer_prior = 0.2;
  double longest_gap = 2.0;
  BeamModelOptions beam_model;
  PoseSearchOptions search;
  HypothesisFilterOptions filter;
  LocalizationMonitorOptions monitor;

  void describe(common::OptionVisitor& visit) {
    visit.real("update_distance", update_distance, {0.0, 10.0}, "m", "Travel after which a scan weighs the particles.");
    visit.real("update_angle", update_angle, {0.0, 3.2}, "rad", "Turn after which a scan weighs the particles.");
    visit.integer("beams", beams, {10, 100000}, "", "Beams that weigh the particles; denser scans are thinned evenly.");
    visit.real("explained_distance", explained_distance, {0.01, 1.0}, "m",
               "A beam is explained when it ends this near to a wall of the map.");
    visit.real(
        "short_weight", short_weight, {0.0, 1.0}, "",
        "How much a beam that ends in free space (a person) counts against the pose, one through a wall being 1.");
    visit.real("search_interval", search_interval, {0.0, 60.0}, "s",
               "Time between two searches of the whole map while the pose is doubtful.");
    visit.real("newcomer_prior", newcomer_prior, {1e-6, 1.0}, "",
               "Probability of all poses together that the search adds and that fit as well as the best hypothesis, "
               "relative to it.");
    visit.real("longest_gap", longest_gap, {0.05, 3600.0}, "s",
               "After a longer time without scans the robot may be anywhere, and the whole map is searched.");
    visit.nested("beam_model", beam_model, "Likelihood of a beam.");
    visit.nested("search", search, "Search of the whole map.");
    visit.nested("filter", filter, "Particles and hypotheses.");
    visit.nested("monitor", monitor, "The verdict TRACKING, UNCERTAIN or LOST.");
  }
};

}  // namespace slamfuse::laser_slam
