// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/path_recorder.hpp"

#include <algorithm>

namespace slamfuse::visual_slam {
using common::Pose3;

void PathRecorder::add(common::Nanoseconds stamp, const Pose3& odometry, const Pose3& estimate, bool lost) {
  entries_.push_back({stamp, segment_, odometry, estimate, lost, false});
}

void PathRecorder::restart_since(common::Nanoseconds since) {
  start_segment();
  for (std::size_t i = entries_.size(); i > frozen_ && entries_[i - 1].stamp >= since; --i) {
    entries_[i - 1].segment = segment_;
    entries_[i - 1].misplaced = true;
  }
}

void PathRecorder::freeze(const Ekf& filter) {
  const std::vector<std::optional<Pose3>> believed = poses_from(frozen_, filter);
  for (std::size_t i = frozen_; i < entries_.size(); ++i) entries_[i].estimate = believed[i - frozen_];
  frozen_ = entries_.size();
  start_segment();
}

common::Trajectory3 PathRecorder::path(const Ekf& filter) const {
  const std::vector<std::optional<Pose3>> believed = poses_from(frozen_, filter);
  common::Trajectory3 path;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const std::optional<Pose3>& pose = i < frozen_ ? entries_[i].estimate : believed[i - frozen_];
    if (pose) path.push_back({entries_[i].stamp, *pose});
  }
  return path;
}

std::vector<PathRecorder::Support> PathRecorder::supports_from(std::size_t first, const Ekf& filter) const {
  std::vector<Support> supports;
  std::size_t entry = first;
  for (const PastPose& past : filter.past_poses()) {
    if (!past.keyframe) continue;
    while (entry < entries_.size() && entries_[entry].stamp < past.stamp) ++entry;
    if (entry < entries_.size() && entries_[entry].stamp == past.stamp && !entries_[entry].misplaced) {
      supports.push_back({entry, filter.spatial_past_pose(past)});
    }
  }
  if (entries_.size() > first && !entries_.back().lost) {
    supports.push_back({entries_.size() - 1, filter.spatial_pose()});
  }
  return supports;
}

std::vector<std::optional<Pose3>> PathRecorder::poses_from(std::size_t first, const Ekf& filter) const {
  const std::vector<Support> supports = supports_from(first, filter);
  std::vector<std::optional<Pose3>> poses;
  poses.reserve(entries_.size() - first);
  std::size_t next = 0;  // first support at or after the entry
  for (std::size_t i = first; i < entries_.size(); ++i) {
    const Entry& here = entries_[i];
    while (next < supports.size() && supports[next].entry < i) ++next;
    const auto carried_from = [&](const Support& support) {
      return support.corrected * entries_[support.entry].odometry.inverse() * here.odometry;
    };
    const bool has_before = next > 0 && entries_[supports[next - 1].entry].segment == here.segment;
    const bool has_after = next < supports.size() && entries_[supports[next].entry].segment == here.segment;
    if (has_before && has_after) {
      const Support& before = supports[next - 1];
      const Support& after = supports[next];
      const double fraction = static_cast<double>(here.stamp - entries_[before.entry].stamp) /
                              static_cast<double>(std::max<common::Nanoseconds>(
                                  1, entries_[after.entry].stamp - entries_[before.entry].stamp));
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
