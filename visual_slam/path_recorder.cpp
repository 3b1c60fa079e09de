// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/path_recorder.hpp"

#include <algorithm>
#include <span>

namespace slamfuse::visual_slam {
using common::Pose3;

void PathRecorder::add(common::Nanoseconds stamp, const Pose3& odometry, bool lost, const Ekf& filter,
                       const ObservationLog& pictures) {
  entries_.push({.stamp = stamp,
                 .segment = segment_,
                 .odometry = odometry,
                 .estimate = filter.spatial_pose(),
                 .lost = lost,
                 .misplaced = false,
                 .frozen = false},
                [&](const Entry& old) { return filter.keyframe_at(old.stamp) || pictures.has(old.stamp); });
}

void PathRecorder::restart_since(common::Nanoseconds since) {
  start_segment();
  const std::span<Entry> entries = entries_.changeable();
  for (std::size_t i = entries.size(); i > 0; --i) {
    Entry& entry = entries[i - 1];
    if (entry.frozen || entry.stamp < since) break;
    entry.segment = segment_;
    entry.misplaced = true;
  }
}

void PathRecorder::freeze(const Ekf& filter) {
  const std::size_t first = frozen();
  const std::vector<std::optional<Pose3>> believed = poses_from(first, filter);
  for (std::size_t i = 0; i < believed.size(); ++i) {
    Entry& entry = entries_.changeable()[first + i];
    entry.estimate = believed[i];
    entry.frozen = true;
  }
  start_segment();
}

void PathRecorder::forget_since(common::Nanoseconds stamp) {
  while (!entries_.items().empty() && entries_.items().back().stamp >= stamp) entries_.pop();
}

std::size_t PathRecorder::frozen() const {
  const auto& entries = entries_.items();
  const auto end = std::ranges::partition_point(entries, [](const Entry& entry) { return entry.frozen; });
  return static_cast<std::size_t>(end - entries.begin());
}

common::Trajectory3 PathRecorder::path(const Ekf& filter) const {
  const std::vector<Entry>& entries = entries_.items();
  const std::size_t first = frozen();
  const std::vector<std::optional<Pose3>> believed = poses_from(first, filter);
  common::Trajectory3 path;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::optional<Pose3>& pose = i < first ? entries[i].estimate : believed[i - first];
    if (pose) path.push_back({entries[i].stamp, *pose});
  }
  return path;
}

std::vector<PathRecorder::Support> PathRecorder::supports_from(std::size_t first, const Ekf& filter) const {
  const std::vector<Entry>& entries = entries_.items();
  std::vector<Support> supports;
  std::size_t entry = first;
  for (const PastPose& past : filter.past_poses()) {
    if (!past.keyframe) continue;
    while (entry < entries.size() && entries[entry].stamp < past.stamp) ++entry;
    if (entry < entries.size() && entries[entry].stamp == past.stamp && !entries[entry].misplaced) {
      supports.push_back({entry, filter.spatial_past_pose(past)});
    }
  }
  if (entries.size() > first && !entries.back().lost) {
    supports.push_back({entries.size() - 1, filter.spatial_pose()});
  }
  return supports;
}

std::vector<std::optional<Pose3>> PathRecorder::poses_from(std::size_t first, const Ekf& filter) const {
  const std::vector<Entry>& entries = entries_.items();
  const std::vector<Support> supports = supports_from(first, filter);
  std::vector<std::optional<Pose3>> poses;
  poses.reserve(entries.size() - first);
  std::size_t next = 0;  // first support at or after the entry
  for (std::size_t i = first; i < entries.size(); ++i) {
    const Entry& here = entries[i];
    while (next < supports.size() && supports[next].entry < i) ++next;
    const auto carried_from = [&](const Support& support) {
      return support.corrected * entries[support.entry].odometry.inverse() * here.odometry;
    };
    const bool has_before = next > 0 && entries[supports[next - 1].entry].segment == here.segment;
    const bool has_after = next < supports.size() && entries[supports[next].entry].segment == here.segment;
    if (has_before && has_after) {
      const Support& before = supports[next - 1];
      const Support& after = supports[next];
      const double fraction = static_cast<double>(here.stamp - entries[before.entry].stamp) /
                              static_cast<double>(std::max<common::Nanoseconds>(
                                  1, entries[after.entry].stamp - entries[before.entry].stamp));
      poses.emplace_back(common::interpolate(carried_from(before), carried_from(after), fraction));
    } else if (here.lost) {
      poses.emplace_back(std::nullopt);
    } else if (has_before) {
      poses.emplace_back(carried_from(supports[next - 1]));
    } else if (has_after) {
      poses.emplace_back(carried_from(supports[next]));
    } else {
      poses.push_back(here.estimate);
    }
  }
  return poses;
}

}  // namespace slamfuse::visual_slam
