// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "common/pose_estimate.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::fusion {

/// What odometry said when a corrected pose was published. Of a long run not all are kept.
struct PublishedPose {
  common::Nanoseconds stamp = 0;
  common::Pose2 T_odom_base;
  std::size_t number = 0;  ///< how many had been published before it
};

/// An estimate that arrived: when, what odometry said, and how many poses had been published up to its stamp.
struct ReceivedEstimate {
  common::Nanoseconds stamp = 0;
  common::PoseSource source = common::PoseSource::kLaser;
  common::TrackingState state = common::TrackingState::kTracking;
  common::Pose2 T_odom_base;
  std::size_t published = 0;  ///< number of the first published pose at or after the stamp
};

/// A pose known at the end, tied to the place in the order of arrival where it belongs.
struct PathAnchor {
  common::Nanoseconds stamp = 0;
  common::Pose2 T_map_base;
  common::Pose2 T_odom_base;
  std::size_t published = 0;
};

/// Ties one half's final path to its estimates: the anchors of the estimates of `source` that were not LOST, in order
/// of arrival, as far as they are both known. Final poses are matched by stamp in order, so stamps may step back
/// (CARMEN logs).
std::vector<PathAnchor> anchors_of(const common::Trajectory2& final_path, common::PoseSource source,
                                   const std::vector<ReceivedEstimate>& received);

/// The anchors as a trajectory in the map frame.
common::Trajectory2 path_of(const std::vector<PathAnchor>& anchors);

/// `main` and, where `main` is silent for longer than `max_silence` on both sides, `substitute`.
std::vector<PathAnchor> fill_gaps(const std::vector<PathAnchor>& main, const std::vector<PathAnchor>& substitute,
                                  common::Nanoseconds max_silence);

/// The path as known at the end, one pose per published one that is known: from the anchors before and after it, moved
/// on and back by odometry and blended in proportion to time. Where the two disagree by more than a metre (the robot
/// was carried) the nearer one counts. Without anchors the path is empty.
common::Trajectory2 smooth_path(const std::vector<PublishedPose>& published, const std::vector<PathAnchor>& anchors);

}  // namespace slamfuse::fusion
