// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/landmark_archive.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>
#include <utility>

namespace slamfuse::visual_slam {
namespace {

using common::Nanoseconds;
using common::Pose3;

std::map<Nanoseconds, Pose3> keyframes_of(const Ekf& filter) {
  std::map<Nanoseconds, Pose3> keyframes;
  for (const PastPose& past : filter.past_poses()) {
    if (past.keyframe) keyframes.emplace(past.stamp, filter.spatial_past_pose(past));
  }
  return keyframes;
}

Nanoseconds nearest(const std::map<Nanoseconds, Pose3>& keyframes, Nanoseconds stamp) {
  const auto after = keyframes.lower_bound(stamp);
  if (after == keyframes.begin()) return after->first;
  const auto before = std::prev(after);
  if (after == keyframes.end()) return before->first;
  return stamp - before->first <= after->first - stamp ? before->first : after->first;
}

/// The motion of everything near a keyframe that was corrected.
struct Motion {
  Motion(const Pose3& before, const Pose3& after)
      : pose(after * before.inverse()), turn(pose.rotation.toRotationMatrix()) {}
  void move(common::Landmark& landmark) const {
    landmark.position = turn * landmark.position + pose.translation;
    landmark.covariance = turn * landmark.covariance * turn.transpose();
  }

  Pose3 pose;
  Eigen::Matrix3d turn;
};

void move(ArchivedLandmark& archived, const Motion& motion) {
  motion.move(archived.landmark);
  archived.relative_covariance = motion.turn * archived.relative_covariance * motion.turn.transpose();
}

}  // namespace

void LandmarkArchive::clear() {
  entries_.clear();
  keyframes_.clear();
}

std::optional<LandmarkId> LandmarkArchive::add(const Ekf& filter, common::Landmark landmark, Nanoseconds last_seen) {
  const std::map<Nanoseconds, Pose3> now = keyframes_of(filter);
  if (now.empty()) return landmark.id;
  const Nanoseconds keyframe = nearest(now, last_seen);
  const LandmarkId id = landmark.id;
  const Eigen::Matrix3d relative = filter.covariance_given(id, *filter.keyframe_at(keyframe));
  entries_.insert_or_assign(id, Entry{{std::move(landmark), last_seen, keyframe, relative}, now.at(keyframe)});
  if (entries_.size() <= capacity_) return std::nullopt;
  const auto worth = [](const Entry& entry) {
    return std::tie(entry.archived.landmark.observations, entry.archived.last_seen);
  };
  const auto spare = std::min_element(entries_.begin(), entries_.end(), [&worth](const auto& a, const auto& b) {
    return worth(a.second) < worth(b.second);
  });
  const LandmarkId gone = spare->first;
  entries_.erase(spare);
  return gone;
}

void LandmarkArchive::follow(const Ekf& filter) {
  std::map<Nanoseconds, Pose3> now = keyframes_of(filter);
  if (now.empty()) return;
  for (auto& [id, entry] : entries_) {
    ArchivedLandmark& archived = entry.archived;
    if (now.contains(archived.keyframe)) continue;
    const auto last = keyframes_.find(archived.keyframe);
    if (last != keyframes_.end()) move(archived, Motion(entry.reference, last->second));
    archived.keyframe = nearest(now, archived.last_seen);
    entry.reference = now.at(archived.keyframe);
  }
  keyframes_ = std::move(now);
}

std::vector<common::Landmark> LandmarkArchive::landmarks(const Ekf& filter) const {
  const std::map<Nanoseconds, Pose3> now = keyframes_of(filter);
  std::vector<common::Landmark> result;
  result.reserve(entries_.size());
  for (const auto& [id, entry] : entries_) {
    result.push_back(entry.archived.landmark);
    const auto here = now.find(entry.archived.keyframe);
    if (here != now.end()) Motion(entry.reference, here->second).move(result.back());
  }
  return result;
}

ArchivedLandmark LandmarkArchive::take(const Ekf& filter, LandmarkId landmark) {
  follow(filter);
  Entry entry = std::move(entries_.extract(landmark).mapped());
  move(entry.archived, Motion(entry.reference, keyframes_.at(entry.archived.keyframe)));
  return std::move(entry.archived);
}

}  // namespace slamfuse::visual_slam
