// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/final_path.hpp"

#include <algorithm>
#include <utility>

namespace slamfuse::fusion {
namespace {

/// Anchors that disagree by more than this [m] have a carry between them, not drift.
constexpr double kCarry = 1.0;

common::Pose2 moved(const PathAnchor& anchor, const common::Pose2& T_odom_base) {
  return anchor.T_map_base * (anchor.T_odom_base.inverse() * T_odom_base);
}

/// How far the pose is on its way from one anchor (0) to the next (1), by stamp, or by order where stamps step back.
double way_between(const PathAnchor& before, const PathAnchor& after, const PublishedPose& pose) {
  if (after.stamp > before.stamp) {
    return std::clamp(static_cast<double>(pose.stamp - before.stamp) / static_cast<double>(after.stamp - before.stamp),
                      0.0, 1.0);
  }
  if (after.published <= before.published) return 0.0;
  const double way = static_cast<double>(pose.number) - static_cast<double>(before.published);
  return std::clamp(way / static_cast<double>(after.published - before.published), 0.0, 1.0);
}

common::Pose2 blend(const PathAnchor& before, const PathAnchor& after, const PublishedPose& pose) {
  const common::Pose2 forward = moved(before, pose.T_odom_base);
  const common::Pose2 backward = moved(after, pose.T_odom_base);
  const double way = way_between(before, after, pose);
  if ((forward.translation() - backward.translation()).norm() > kCarry) return way < 0.5 ? forward : backward;
  return common::interpolate(forward, backward, way);
}

}  // namespace

std::vector<PathAnchor> anchors_of(const common::Trajectory2& final_path, common::PoseSource source,
                                   const std::vector<ReceivedEstimate>& received) {
  std::vector<std::pair<common::Nanoseconds, std::size_t>> places;  // of the estimates of the source, by stamp
  for (std::size_t i = 0; i < received.size(); ++i) {
    if (received[i].source == source) places.emplace_back(received[i].stamp, i);
  }
  std::sort(places.begin(), places.end());
  std::vector<PathAnchor> anchors;
  std::size_t next = 0;
  for (const common::StampedPose2& pose : final_path) {
    const auto place = std::lower_bound(places.begin(), places.end(), std::pair(pose.stamp, next));
    if (place == places.end() || place->first != pose.stamp) continue;
    const ReceivedEstimate& match = received[place->second];
    next = place->second + 1;
    if (match.state == common::TrackingState::kLost || !pose.pose.is_finite()) continue;
    anchors.push_back({pose.stamp, pose.pose, match.T_odom_base, match.published});
  }
  return anchors;
}

common::Trajectory2 path_of(const std::vector<PathAnchor>& anchors) {
  common::Trajectory2 path;
  path.reserve(anchors.size());
  for (const PathAnchor& anchor : anchors) path.push_back({anchor.stamp, anchor.T_map_base});
  return path;
}

std::vector<PathAnchor> fill_gaps(const std::vector<PathAnchor>& main, const std::vector<PathAnchor>& substitute,
                                  common::Nanoseconds max_silence) {
  std::vector<common::Nanoseconds> stamps;
  for (const PathAnchor& anchor : main) stamps.push_back(anchor.stamp);
  std::sort(stamps.begin(), stamps.end());
  std::vector<PathAnchor> filled = main;
  for (const PathAnchor& anchor : substitute) {
    const auto near = std::lower_bound(stamps.begin(), stamps.end(), anchor.stamp - max_silence);
    if (near == stamps.end() || *near > anchor.stamp + max_silence) filled.push_back(anchor);
  }
  std::stable_sort(filled.begin(), filled.end(),
                   [](const PathAnchor& a, const PathAnchor& b) { return a.published < b.published; });
  return filled;
}

common::Trajectory2 smooth_path(const std::vector<PublishedPose>& published, const std::vector<PathAnchor>& anchors) {
  common::Trajectory2 path;
  if (anchors.empty()) return path;
  path.reserve(published.size());
  std::size_t after = 0;  // first anchor that belongs behind the pose
  for (const PublishedPose& pose : published) {
    while (after < anchors.size() && anchors[after].published <= pose.number) ++after;
    common::Pose2 known;
    if (after == 0) {
      known = moved(anchors.front(), pose.T_odom_base);
    } else if (after == anchors.size()) {
      known = moved(anchors.back(), pose.T_odom_base);
    } else {
      known = blend(anchors[after - 1], anchors[after], pose);
    }
    path.push_back({pose.stamp, known});
  }
  return path;
}

}  // namespace slamfuse::fusion
