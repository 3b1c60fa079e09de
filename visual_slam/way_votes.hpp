// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>

namespace slamfuse::visual_slam {

/// What a patch of a picture, found again in an earlier one, says of the way driven: this way [m] with this standard
/// deviation, if it shows the floor.
struct WayVote {
  double way = 0.0;
  double sigma = 0.0;
};

/// The ways that are possible [m].
struct WayRange {
  double least = 0.0;
  double most = 0.0;
};

/// The way [m] at which all that patches say is likeliest. A patch shows the floor, or something above it, which seems
/// to move as if the way were longer, the more so the nearer it is, or says anything. Empty when other ways, more than
/// 12 mm off or within 4 mm of the end of the range, are not unlikely together (1 %). Not in the seeds.
std::optional<double> likeliest_way(std::span<const WayVote> votes, const WayRange& range);

}  // namespace slamfuse::visual_slam
