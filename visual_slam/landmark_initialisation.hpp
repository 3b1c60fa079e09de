// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "visual_slam/camera.hpp"
#include "visual_slam/measurement_model.hpp"
#include "visual_slam/options.hpp"
#include "visual_slam/state.hpp"

namespace slamfuse::visual_slam {

/// What is believed of the depth of a landmark seen for the first time.
struct DepthGuess {
  double inverse_depth = 0.0;  ///< [1/m]
  double sigma = 0.0;          ///< [1/m]
};

/// Enters a landmark seen for the first time into the state by inverse depth, undelayed (seed 002 section 2.3): its ray
/// is as noisy as its bearing.
BlockId enter_by_inverse_depth(State& state, const Bearing& bearing, const DepthGuess& depth);

enum class PairOutcome {
  kMisfit,   ///< the bearing does not fit the epipolar line
  kFits,     ///< it does, but does not fix the landmark's place
  kEntered,  ///< the landmark is a point of the state now, and its anchor pose is no longer needed for it
};

/// Takes another bearing of a landmark that waits. The bearing is tested against the epipolar line; when the pair it
/// makes with the first sight passes the test of seed 000 section II.E, the landmark enters as a point. `model` is a
/// view on `state`.
PairOutcome pair_up(State& state, const MeasurementModel& model, FilterLandmark& landmark, const Camera& camera,
                    const Bearing& bearing, const FilterOptions& options);

enum class Conversion {
  kNotYet,
  kDone,        ///< the landmark is a point now, and its anchor pose is no longer needed for it
  kImpossible,  ///< its inverse depth is clearly below 0: it is no point of this world
};

/// Makes a landmark known by inverse depth Cartesian when it has become linear enough for `camera`, which sees it now
/// (linearity_index()). `model` is a view on `state`.
Conversion make_cartesian(State& state, const MeasurementModel& model, FilterLandmark& landmark, const Camera& camera,
                          double largest_index);

}  // namespace slamfuse::visual_slam
