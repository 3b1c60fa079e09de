// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/similarity2.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::common {

/// How an estimated trajectory is brought into the reference's frame before it is compared.
enum class EvaluationAlignment {
  kNone,  ///< not at all: both are in one frame
  kSe2,   ///< rotation and translation fitted (Umeyama)
  kSim2,  ///< and one scale: only for estimates without odometry, which have none of their own
  kAs,    ///< a given transform, e.g. the one fitted on the mapping run when judging a run that localises in its map
};

/// "none", "se2", "sim2", "as": as in metrics.json.
std::string to_string(EvaluationAlignment align);

struct EvaluationOptions {
  EvaluationAlignment align = EvaluationAlignment::kSe2;
  Similarity2 T_reference_estimate;  ///< used with kAs
  /// A pose is compared only if the reference stands this close on both sides of it, or exactly at its stamp. Zero
  /// compares at equal stamps only (corrected CARMEN logs: file order matters there, interpolation in time would be
  /// wrong).
  Nanoseconds max_reference_gap = kNanosecondsPerSecond / 10;
  /// For a reference by another system, a motion capture: with kSe2, one constant offset of the body it tracks from
  /// base_link and one constant difference of the clocks (up to kMostClockOffset) are fitted together with the
  /// alignment, by the least squares of the positions.
  bool fit_offset = false;
};

/// Largest difference of the clocks that is looked for.
inline constexpr Nanoseconds kMostClockOffset = kNanosecondsPerSecond * 3 / 10;

/// How far one pose is off.
struct PoseError {
  Nanoseconds stamp = 0;
  double position = 0.0;  ///< distance [m], >= 0
  double heading = 0.0;   ///< estimate minus reference [rad], in (-pi, pi]
};

struct TrajectoryAccuracy {
  EvaluationAlignment align = EvaluationAlignment::kSe2;
  Similarity2 T_reference_estimate;  ///< what the estimate was moved by
  Pose2 T_base_body;                 ///< with fit_offset: the tracked body on the robot
  Nanoseconds clock_offset = 0;      ///< with fit_offset: added to the estimate's stamps
  double ate_rmse_m = 0.0;           ///< root mean square of the position errors
  double ate_max_m = 0.0;
  double heading_rmse_deg = 0.0;
  /// Mean over all sub-paths of kSubPathLength of the relative translation error, in percent of the sub-path's length.
  /// Empty where the path is shorter.
  std::optional<double> rpe_percent;
  double coverage = 0.0;          ///< 0..1, see evaluate_trajectory()
  std::vector<PoseError> errors;  ///< of every compared pose, in the order of the estimate
};

/// Length [m] of the sub-paths of the relative error: long enough that the centimetres of noise of single poses weigh
/// little (2 cm are 0.4 %), short enough to have many of them in one flat.
inline constexpr double kSubPathLength = 5.0;

/// Compares an estimate (in the order its poses were made, stamps may step back) with a reference of the same frame
/// (base_link with base_link). The rules of DESIGN section 5:
///
/// - The reference is interpolated at the estimate's stamps, nowhere over a hole wider than allowed.
/// - A carry is a hole of the reference of more than 0.5 s over which the position jumps by more than 0.5 m. The
///   alignment is fitted on the poses before the first carry only, and no sub-path of the relative error spans one; the
///   errors of all poses count.
/// - Coverage is the time within 0.5 s after a pose divided by the time with reference; holes of the reference of more
///   than 0.1 s are left out of both. For a sparse reference (more than half of its steps are longer than 0.1 s) it is
///   the share of reference poses with an estimate in the 0.5 s before them, and there are no carries.
///
/// Errors (kInvalidInput): the two have no pose in common, or too few or all in one place to fit the alignment. Error
/// (kUsage): an offset is to be fitted with another alignment than se2.
Result<TrajectoryAccuracy> evaluate_trajectory(const Trajectory2& estimate, const Trajectory2& reference,
                                               const EvaluationOptions& options = {});

}  // namespace slamfuse::common
