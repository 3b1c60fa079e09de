// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/observation_log.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/angle.hpp"
#include "visual_slam/projection.hpp"

namespace slamfuse::visual_slam {
namespace {

/// The picture that is missed least: not the first or the last, the one with the shortest time around it.
std::size_t spare_picture(const std::vector<KeptPicture>& pictures) {
  std::size_t spare = 0;
  common::Nanoseconds shortest = std::numeric_limits<common::Nanoseconds>::max();
  for (std::size_t i = 1; i + 1 < pictures.size(); ++i) {
    const common::Nanoseconds gap = pictures[i + 1].stamp - pictures[i - 1].stamp;
    if (gap < shortest) {
      shortest = gap;
      spare = i;
    }
  }
  return spare;
}

}  // namespace

void ObservationLog::offer(std::size_t camera, common::Nanoseconds stamp, const common::Pose2& odometry,
                           std::span<const Track> tracks) {
  if (tracks.empty()) return;
  CameraPictures& kept = cameras_[camera];
  if (kept.last) {
    const common::Pose2 since = kept.last->inverse() * odometry;
    if (since.translation().norm() <= options_.keyframe_distance &&
        std::abs(since.theta) <= common::to_radians(options_.keyframe_turn)) {
      return;
    }
  }
  kept.last = odometry;
  KeptPicture& picture = kept.pictures.emplace_back();
  picture.stamp = stamp;
  for (const Track& track : tracks) picture.observations.push_back({track.landmark, track.pixel});
  if (static_cast<int>(kept.pictures.size()) > options_.max_keyframes) {
    kept.pictures.erase(kept.pictures.begin() + static_cast<std::ptrdiff_t>(spare_picture(kept.pictures)));
  }
}

std::span<const KeptPicture> ObservationLog::pictures(std::size_t camera) const {
  const auto found = cameras_.find(camera);
  if (found == cameras_.end()) return {};
  return found->second.pictures;
}

bool ObservationLog::has(common::Nanoseconds stamp) const {
  return std::ranges::any_of(cameras_, [stamp](const auto& camera) {
    return std::ranges::binary_search(camera.second.pictures, stamp, {}, &KeptPicture::stamp);
  });
}

std::vector<common::Keyframe> keyframes_of(const ObservationLog& log, std::span<const Camera> cameras,
                                           const common::Trajectory3& path, double lever_scale) {
  std::vector<common::Keyframe> keyframes;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    for (const KeptPicture& picture : log.pictures(i)) {
      const auto at = std::lower_bound(path.begin(), path.end(), picture.stamp,
                                       [](const auto& pose, common::Nanoseconds stamp) { return pose.stamp < stamp; });
      if (at == path.end() || at->stamp != picture.stamp) continue;
      common::Pose3 T_map_camera;
      T_map_camera.translation = optical_centre(cameras[i], at->pose, lever_scale);
      T_map_camera.rotation = at->pose.rotation * cameras[i].calibration.T_base_camera.rotation;
      keyframes.push_back({cameras[i].name, picture.stamp, T_map_camera, picture.observations});
    }
  }
  return keyframes;
}

}  // namespace slamfuse::visual_slam
