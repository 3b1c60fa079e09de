// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/path_recorder.hpp"

#include <algorithm>

namespace slamfuse::visual_slam {
namespace {

using common::Pose3;

/// A pose known well: its place in the path and what the filter and the odometry say of it.
struct Support {
  std::size_t entry;
  Pose3 corrected;
};

}  // namespace

void PathRecorder::add(common::Nanoseconds stamp, const Pose3& odometry, const Pose3& estimate) {
  entries_.push_back({stamp, segment_, odometry, estimate, false});
}

void PathRecorder::restart_since(common::Nanoseconds since) {
  start_segment();
  for (std::size_t i = entries_.size(); i > frozen_ && entries_[i - 1].stamp >= since; --i) {
    entries_[i - 1].segment = segment_;
    entries_[i - 1].misplaced = true;
  }
}

void PathRecorder::freeze(const Ekf& filter) {
  const common::Trajectory3 believed = path_from(frozen_, filter);
  for (std::size_t i = frozen_; i < entries_.size(); ++i) entries_[i].estimate = believed[i - frozen_].pose;
  frozen_ = entries_.size();
  start_segment();
}

common::Trajectory3 PathRecorder::path(const Ekf& filter) const {
  common::Trajectory3 path;
  for (std::size_t i = 0; i < frozen_; ++i) path.push_back({entries_[i].stamp, entries_[i].estimate});
  const common::Trajectory3 rest = path_from(frozen_, filter);
  path.insert(path.end(), rest.begin(), rest.end());
  return path;
}

common::Trajectory3 PathRecorder::path_from(std::size_t first, const Ekf& filter) const {
  std::vector<Support> supports;
  std::size_t entry = first;
  for (const PastPose& past : filter.past_poses()) {
    if (!past.keyframe) continue;
    while (entry < entries_.size() && entries_[entry].stamp < past.stamp) ++entry;
    if (entry < entries_.size() && entries_[entry].stamp == past.stamp && !entries_[entry].misplaced) {
      supports.push_back({entry, filter.spatial_past_pose(past)});
    }
  }
  if (entries_.size() > first) supports.push_back({entries_.size() - 1, filter.spatial_pose()});

  common::Trajectory3 path;
  path.reserve(entries_.size() - first);
  std::size_t next = 0;  // first support at or after the entry
  for (std::size_t i = first; i < entries_.size(); ++i) {
    const Entry& here = entries_[i];
    path.push_back({here.stamp, here.estimate});
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
      path.back().pose = common::interpolate(carried_from(before), carried_from(after), fraction);
    } else if (has_before) {
      path.back().pose = carried_from(supports[next - 1]);
    } else if (has_after) {
      path.back().pose = carried_from(supports[next]);
    }
  }
  return path;
}

}  // namespace slamfuse::visual_slam
