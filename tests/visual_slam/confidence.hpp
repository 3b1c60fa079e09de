// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/pose_estimate.hpp"
#include "common/time.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::visual_slam::testing {

/// An estimate beside the truth.
struct JudgedEstimate {
  common::Nanoseconds stamp = 0;
  common::TrackingState state = common::TrackingState::kTracking;
  double position = 0.0;     ///< error [m]
  double heading = 0.0;      ///< error [rad], >= 0
  double mahalanobis = 0.0;  ///< squared, of the error by the estimate's covariance, three degrees of freedom
};

/// Compares estimates with the truth in the frame that fits those up to `fit_until` best (rotation and translation):
/// what comes later may not hide its errors in the frame. Estimates without truth are left out.
std::vector<JudgedEstimate> judge(const std::vector<common::PoseEstimate>& estimates, const common::Trajectory2& truth,
                                  common::Nanoseconds fit_until);

/// How far off a pose called TRACKING may be whatever its covariance says.
inline constexpr double kMaxPosition = 0.15;  ///< [m]
inline constexpr double kMaxHeading = 0.05;   ///< [rad]

/// Whether the estimate claims to be right and is not: TRACKING, off by more than the bounds above and by more than its
/// covariance allows (chi-square of three degrees of freedom, 0.999).
bool is_false_confidence(const JudgedEstimate& estimate);

}  // namespace slamfuse::visual_slam::testing
