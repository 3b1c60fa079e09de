// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "visual_slam/relocaliser.hpp"

namespace slamfuse::visual_slam {

/// Asks now and then, while the estimate is tracking, whether what is seen is an old part of the map seen from
/// elsewhere: a loop whose drift is beyond the search regions of the filter.
///
/// It is a Relocaliser on the landmarks unseen for a while. What it finds is believed only when it could be drift: the
/// pose is off by no more than a share of the way driven since those landmarks were seen. A room that merely looks like
/// an old one is not where drift could have taken the robot.
class LoopSearch {
 public:
  /// The landmarks that have not been seen since a stamp.
  using OldMap = std::function<std::vector<common::Landmark>(common::Nanoseconds)>;

  LoopSearch(const LoopOptions& options, const RelocalisationOptions& relocalisation, std::uint64_t seed);

  /// Whether an image at this stamp is to be looked at.
  bool is_due(common::Nanoseconds stamp) const;
  /// Takes the features of an image that is due; `estimate` is T_map_base there as the filter has it. Returns the pose
  /// the old landmarks say when they say it consistently and it could be drift.
  std::optional<Relocalisation> look(const OldMap& map, const Glimpse& glimpse, const common::Pose2& estimate,
                                     const cv::Mat& picture, std::span<const Eigen::Vector2d> features);
  /// The map has changed under it, or the pose has jumped.
  void clear();

 private:
  bool could_be_drift(const common::Pose2& estimate, const common::Pose2& found) const;

  LoopOptions options_;
  RelocalisationOptions relocalisation_;
  Relocaliser relocaliser_;
  std::optional<LandmarkIndex> index_;
  common::Nanoseconds indexed_ = 0;            // stamp at which it was made
  std::optional<common::Nanoseconds> looked_;  // newest image that was looked at
  common::Pose2 last_odometry_;
  double way_ = 0.0;  // driven [m]
};

}  // namespace slamfuse::visual_slam
