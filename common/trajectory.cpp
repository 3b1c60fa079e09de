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
  const auto not_later = [](const auto& a, const auto& b) { return a.stamp >= b.stamp; };
  if (std::adjacent_find(trajectory.begin(), trajectory.end(), not_later) == trajectory.end()) return trajectory;
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

namespace {

bool is_before(const StampedPose2& pose, Nanoseconds stamp) { return pose.stamp < stamp; }

/// The pose at `stamp`, before which the poses in front of `after` are.
std::optional<Pose2> pose_between(const Trajectory2& trajectory, Trajectory2::const_iterator after, Nanoseconds stamp,
                                  Nanoseconds max_gap) {
  if (after == trajectory.end()) return std::nullopt;
  if (after->stamp == stamp) return after->pose;
  if (after == trajectory.begin()) return std::nullopt;
  const auto before = std::prev(after);
  if (stamp - before->stamp > max_gap || after->stamp - stamp > max_gap) return std::nullopt;
  return interpolate(before->pose, after->pose,
                     static_cast<double>(stamp - before->stamp) / static_cast<double>(after->stamp - before->stamp));
}

}  // namespace

std::optional<Pose2> pose_at(const Trajectory2& trajectory, Nanoseconds stamp, Nanoseconds max_gap) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), stamp, is_before);
  return pose_between(trajectory, after, stamp, max_gap);
}

std::optional<Pose2> PoseCursor::at(Nanoseconds stamp) {
  // Steps that double, from the last place into the direction of the stamp, then halving between the last two.
  const auto size = static_cast<std::ptrdiff_t>(trajectory_.size());
  const auto before = [&](std::ptrdiff_t i) { return is_before(trajectory_[static_cast<std::size_t>(i)], stamp); };
  std::ptrdiff_t low = place_;   // all in front of it are before the stamp
  std::ptrdiff_t high = place_;  // it and all behind it are not
  for (std::ptrdiff_t step = 1; high < size && before(high); step *= 2) {
    low = high + 1;
    high = std::min(high + step, size);
  }
  for (std::ptrdiff_t step = 1; low > 0 && !before(low - 1); step *= 2) {
    high = low - 1;
    low = std::max<std::ptrdiff_t>(low - step, 0);
  }
  const auto begin = trajectory_.begin();
  const auto after = std::lower_bound(begin + low, begin + high, stamp, is_before);
  place_ = after - begin;
  return pose_between(trajectory_, after, stamp, max_gap_);
}

}  // namespace slamfuse::common
