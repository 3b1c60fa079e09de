// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/options.hpp"
#include "fusion/robust_fit.hpp"
#include "fusion/seed004.hpp"
#include "fusion/sensor_offsets.hpp"
#include "fusion/trajectory_pairing.hpp"

namespace slamfuse::fusion {

/// How the map between the two trajectories is found.
enum class AlignmentMethod {
  kSeed004,     ///< the paper's image-like pipeline
  kRigid,       ///< robust rotation and shift, scale 1
  kSimilarity,  ///< robust rotation, shift and one scale
  kAffine,      ///< robust affine map: a scale per axis
  kAuto,        ///< rigid where the scale is known, else similarity, or affine where that is clearly better
};

/// The word for a method in configuration, metrics.json and map.yaml.
std::string to_string(AlignmentMethod method);

/// When an alignment is trusted, and how it is made.
struct AlignmentOptions {
  AlignmentMethod method = AlignmentMethod::kAuto;
  double scale_tolerance = 0.05;
  double affine_gain = 0.9;
  double affine_straightness_ratio = 0.2;
  int min_pairs = 20;
  int most_pairs = 2000;
  double min_path = 1.0;
  double min_straightness_ratio = 0.05;
  double min_runner_up_ratio = 1.5;
  double runner_up_separation = 20.0;
  double max_relative_error = 0.2;
  double min_inlier_share = 0.5;
  int heldout_block = 10;
  double offset_gain = 0.95;
  SensorOffsetOptions offsets;
  PairingOptions pairing;
  RobustFitOptions robust;
  Seed004Options seed004;

  void describe(common::OptionVisitor& visit) {
    visit.choice("method", method,
                 {{"auto", AlignmentMethod::kAuto},
                  {"rigid", AlignmentMethod::kRigid},
                  {"similarity", AlignmentMethod::kSimilarity},
                  {"affine", AlignmentMethod::kAffine},
                  {"seed004", AlignmentMethod::kSeed004}},
                 "How the map between the frames is found; auto: similarity, or affine where that lowers the "
                 "held-out error clearly, or rigid where their scales say so.");
    visit.real(
        "scale_tolerance", scale_tolerance, {0.0, 0.5}, "",
        "Method auto keeps the scale of metric visual poses at 1 where a fitted one is off 1 by less than this and "
        "three of its standard deviations: on a short path a scale fits the drift of the halves.");
    visit.real(
        "affine_gain", affine_gain, {0.0, 1.0}, "",
        "Method auto takes the affine map only if its held-out error is below this part of the similarity's: two "
        "more numbers always fit better and extrapolate worse.");
    visit.real("affine_straightness_ratio", affine_straightness_ratio, {0.0, 1.0}, "",
               "Method auto considers the affine map only if the path is at least this wide (as "
               "min_straightness_ratio): across a narrow one the second scale is hardly seen.");
    visit.integer("min_pairs", min_pairs, {6, 100000}, "", "Fewer pairs are refused.");
    visit.integer("most_pairs", most_pairs, {100, 10000000}, "",
                  "Of more pairs so many are used, evenly spread: neighbours share their errors.");
    visit.real("min_path", min_path, {0.0, 1000.0}, "m", "A shorter laser path within the pairs is refused.");
    visit.real("min_straightness_ratio", min_straightness_ratio, {0.0, 1.0}, "",
               "Narrow over wide standard deviation of the positions below which a path is refused as straight.");
    visit.real("min_runner_up_ratio", min_runner_up_ratio, {1.0, 100.0}, "",
               "Loss of the second-best, well-separated angle over the best; below it the angle is ambiguous.");
    visit.real("runner_up_separation", runner_up_separation, {1.0, 90.0}, "deg",
               "How far another angle must be from the best one to count as the runner-up.");
    visit.real("max_relative_error", max_relative_error, {0.001, 1.0}, "",
               "Held-out error over the standard deviation of the laser's positions above which the fit is refused.");
    visit.real("min_inlier_share", min_inlier_share, {0.0, 1.0}, "",
               "Share of pairs that must agree with a common map.");
    visit.integer("heldout_block", heldout_block, {1, 10000}, "pairs",
                  "Every fourth block of this many neighbouring pairs is held out of a fit to test it.");
    visit.real(
        "offset_gain", offset_gain, {0.0, 1.0}, "",
        "Clock offset and lever arm are used only if the held-out error with them is below this part of that without.");
    visit.nested("offsets", offsets, "Clock offset and lever arm between the two sensors.");
    visit.nested("pairing", pairing, "Pairing of the poses by time.");
    visit.nested("robust", robust, "Robust direct estimators (similarity, affine).");
    visit.nested("seed004", seed004, "The paper's pipeline.");
  }
};

}  // namespace slamfuse::fusion
