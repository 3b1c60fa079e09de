// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/annotated_image.hpp"
#include "common/calibration.hpp"
#include "common/error.hpp"
#include "common/keyframe.hpp"
#include "common/landmark.hpp"
#include "common/slam_module.hpp"
#include "common/thinned_history.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// What a saved map is for.
enum class MapUse {
  kContinue,  ///< new landmarks are added
  kLocalise,  ///< the pose alone is estimated
};

/// Monocular and multi-camera EKF SLAM (seeds 000 to 002): wheel odometry, or without it a constant velocity (then the
/// map has a scale of its own unless one camera reads metres from the floor, see FloorReckoning, ConstantVelocity and
/// FreeCamera), predicts the pose of base_link, planar but for a
/// free camera, the features of any number of cameras, each with its own stamps, rate, mounting and lens, correct it
/// and the landmarks.
///
/// The map frame is base_link at the first image. Estimates of a free camera are the part of its pose in the plane.
/// Each accepted image makes one estimate at its own stamp, moved by what the camera's clock is believed to be off
/// (ImageClock). Where that changes the map is made anew (map_reset), and of images that come a second time by their
/// new stamps nothing is told until they are newer than what was.
class VisualSlam : public common::SlamModule {
 public:
  /// `cameras` are the ones to listen to, by sensor name. `threads` only speeds up the work, the result does not depend
  /// on it. Of the path at most `most_kept` poses are kept, thinned beyond (see common::ThinnedHistory); those of
  /// keyframes and remembered pictures stay. Errors (kInvalidInput): no camera, a calibration without size or focal
  /// length, a feature selection by known objects without usable pictures of them.
  static common::Result<std::unique_ptr<VisualSlam>> create(
      const VisualSlamOptions& options, const std::map<std::string, common::CameraCalibration>& cameras,
      std::uint64_t seed, int threads, std::size_t most_kept = common::kKeepAll);
  ~VisualSlam() override;

  common::PoseSource source() const override { return common::PoseSource::kVisual; }
  /// Images of the cameras it was made for, and wheel odometry if it is the motion model.
  bool wants(const common::SensorMessage& message) const override;
  /// Rejects images of the wrong size, of an unknown camera, with a stamp that repeats or steps back for that camera,
  /// older than the newest estimate, and, with odometry as the motion model,
  /// images at whose stamp none is known.
  common::ProcessResult process(const common::SensorMessage& message) override;
  /// SetPose replaces the pose and keeps the map; Reset forgets the map, a loaded one too, and starts the next epoch at
  /// the origin. Relocalise makes the estimate LOST until the pose is found in the whole map.
  void execute(const common::Command& command) override;
  /// The path corrected by everything seen since: keyframe poses stay in the filter's state and are smoothed by its
  /// cross-covariances; poses between two keyframes take the correction interpolated between them.
  common::Trajectory2 final_trajectory() const override;
  /// The same with height, pitch and roll, which a free camera has.
  common::Trajectory3 spatial_trajectory() const;

  /// Whether a pose can be found in the whole map: not with a free camera, or when it is switched off.
  bool can_search() const;
  /// Takes a saved map in place of its own, whose frame holds from now on (after the first image: in a new epoch). The
  /// estimate is LOST until the pose is found in it or set. The map's landmarks are never changed; their uncertainty
  /// counts as noise of their measurements (seed 000 section G). Errors (kInvalidInput): a place that is no number, a
  /// number that occurs twice, no landmark that could be recognised.
  common::Result<void> load(const std::vector<common::Landmark>& map, MapUse use);

  /// The landmarks of the current epoch whose depth is known, in the visual map's frame: those in the filter, those
  /// that have left it, and those of a loaded map as they were saved.
  std::vector<common::Landmark> landmarks() const;

  /// The pictures of the current epoch that are remembered, by camera and then by time, with their poses as believed
  /// now. Their observations may name landmarks that have left the map since.
  std::vector<common::Keyframe> keyframes() const;

  /// A few images of each camera, spread over the run, with what became of their features.
  std::vector<common::AnnotatedImage> sample_images() const;

 private:
  class Implementation;
  explicit VisualSlam(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace slamfuse::visual_slam
