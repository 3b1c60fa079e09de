// SPDX-License-Identifier: BSD-3-Clause
#include "common/trajectory.hpp"

#include <algorithm>

namespace slamfuse::common {

double path_length(const Trajectory2& trajectory) {
  double length = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length += (trajectory[i].pose.translation() - trajectory[i - 1].pose.translation()).norm();
  }
  return length;
}

Trajectory2 sorted_by_stamp(const Trajectory2& trajectory) {
  Trajectory2 sorted = trajectory;
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  Trajectory2 unique;
  unique.reserve(sorted.size());
  for (const StampedPose2& pose : sorted) {
    if (!unique.empty() && unique.back().stamp == pose.stamp) unique.pop_back();
    unique.push_back(pose);
  }
  return unique;
}

Trajectory2 to_planar(const Trajectory3& trajectory) {
  Trajectory2 planar;
  planar.reserve(trajectory.size());
  for (const StampedPose3& pose : trajectory) planar.push_back({pose.stamp, to_pose2(pose.pose)});
  return planar;
}

Trajectory3 to_spatial(const Trajectory2& trajectory) {
  Trajectory3 spatial;
  spatial.reserve(trajectory.size());
  for (const StampedPose2& pose : trajectory) spatial.push_back({pose.stamp, to_pose3(pose.pose)});
  return spatial;
}

std::optional<Pose2> pose_at(const Trajectory2& trajectory, Nanoseconds stamp, Nanoseconds max_gap) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), stamp,
                                      [](const StampedPose2& pose, Nanoseconds t) { return pose.stamp < t; });
  if (after == trajectory.end()) return std::nullopt;
  if (after->stamp == stamp) return after->pose;
  if (after == trajectory.begin()) return std::nullopt;
  const auto before = std::prev(after);
  if (stamp - before->stamp > max_gap || after->stamp - stamp > max_gap) return std::nullopt;
  return interpolate(before->pose, after->pose,
                     static_cast<double>(stamp - before->stamp) / static_cast<double>(after->stamp - before->stamp));
}

}  // namespace slamfuse::common
