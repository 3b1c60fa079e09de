// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/trajectory.hpp"

namespace slamfuse::common {

/// For how long a pose counts as covering the time after it (DESIGN section 5).
inline constexpr Nanoseconds kCoveredByPose = kNanosecondsPerSecond / 2;
/// A reference without a pose for longer than this has a hole there.
inline constexpr Nanoseconds kReferenceHole = kNanosecondsPerSecond / 10;

/// Whether more than half of the steps between the poses are holes, as in a corrected log with every tenth scan.
/// `reference` is sorted by stamp.
bool is_sparse(const Trajectory2& reference);

/// The share, 0 to 1, of the time with reference that lies within 0.5 s after a pose of the estimate; holes of the
/// reference are left out of both. For a sparse reference the share of its poses with an estimate in the 0.5 s before
/// them. `reference` is sorted by stamp; `estimate` holds no pose where the estimator was lost and may be in any order.
double trajectory_coverage(const Trajectory2& estimate, const Trajectory2& reference);

/// The share, 0 to 1, of the time from `first` to `last` that lies within 0.5 s after a pose of the estimate: coverage
/// where there is no reference.
double time_coverage(const Trajectory2& estimate, Nanoseconds first, Nanoseconds last);

}  // namespace slamfuse::common
