// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "common/keyframe.hpp"
#include "common/pose2.hpp"
#include "common/time.hpp"
#include "common/trajectory.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/camera_tracks.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// A picture of a camera that is remembered, without its pixels.
struct KeptPicture {
  common::Nanoseconds stamp = 0;
  std::vector<common::KeyframeObservation> observations;
};

/// Remembers which landmarks were seen where in the cameras' pictures: the "tracks" of a structure-and-motion model
/// (seed 002 section 3.1). The filter itself forgets measurements once it has used them.
///
/// A picture is kept when its camera has moved by `map.keyframe_distance` or turned by `map.keyframe_turn` since the
/// last one kept. Memory is bounded: at most `map.max_keyframes` pictures a camera; over that the picture goes whose
/// neighbours are nearest to each other in time, so the run stays covered evenly.
class ObservationLog {
 public:
  explicit ObservationLog(const MapOptions& options) : options_(options) {}

  /// Offers a picture with the landmarks found in it; `odometry` is T_odom_base at its stamp. Stamps of a camera rise.
  void offer(std::size_t camera, common::Nanoseconds stamp, const common::Pose2& odometry,
             std::span<const Track> tracks);
  /// The map was forgotten: what was seen belongs to no landmark any more.
  void clear() { cameras_.clear(); }
  /// The pictures kept of a camera, by rising stamp.
  std::span<const KeptPicture> pictures(std::size_t camera) const;
  /// Whether a picture of that stamp is kept, of whichever camera.
  bool has(common::Nanoseconds stamp) const;

 private:
  struct CameraPictures {
    std::optional<common::Pose2> last;  // odometry at the newest picture kept
    std::vector<KeptPicture> pictures;
  };

  MapOptions options_;
  std::map<std::size_t, CameraPictures> cameras_;
};

/// The pictures kept, by camera and then by time, with the cameras' poses on `path`, whose stamps never step back;
/// without those at whose stamp the path has no pose. `lever_scale` is how many units of the map a metre is.
std::vector<common::Keyframe> keyframes_of(const ObservationLog& log, std::span<const Camera> cameras,
                                           const common::Trajectory3& path, double lever_scale);

}  // namespace slamfuse::visual_slam
