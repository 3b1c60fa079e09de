// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"

namespace slamfuse::common {

/// Where two bodies on one robot stand to each other, and how their frames do.
struct OffsetFit {
  Pose2 T_reference_estimate;
  Pose2 T_base_body;  ///< the heading by the mean difference, it does not act on the positions
  double rmse = 0.0;  ///< of the positions [m]
};

/// Fits `T_reference_estimate * estimate[i] * T_base_body ~ reference[i]`: least squares of the positions by
/// Gauss-Newton, begun at the rigid fit without offset. What the path leaves open (a robot that never turns does not
/// tell the offset from the frame) stays as small as it can be. Returns nothing for fewer than three poses or all in
/// one place.
std::optional<OffsetFit> fit_offset(const std::vector<Pose2>& estimate, const std::vector<Pose2>& reference);

}  // namespace slamfuse::common
