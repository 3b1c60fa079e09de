// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "common/time.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/ekf.hpp"
#include "visual_slam/floor_speed.hpp"
#include "visual_slam/options.hpp"
#include "visual_slam/turn_by_way.hpp"

namespace slamfuse::visual_slam {

/// A picture the floor may be seen in, and what is known of the step to it.
struct FloorView {
  std::size_t camera_index = 0;
  const Camera& camera;
  cv::Mat picture;  ///< empty when nothing can be seen in it
  common::Nanoseconds stamp = 0;
  double seconds = 0.0;                   ///< since the last image
  std::span<const LandmarkId> landmarks;  ///< seen in it, of known depth
  bool landmarks_spoke = false;           ///< they are enough, and the filter has been corrected by them
  std::span<const FollowedFeature> followed;
};

/// Keeps the unit of a filter without wheel odometry a metre by the speed the floor tells.
///
/// Landmarks of known depth tell the speed better than the floor, which may be a bed, but not how long a metre is; and
/// what learns its depth from a wrong speed and then teaches the speed never finds out. So the floor speaks after the
/// landmarks of known depth and before the others learn theirs. From one image to the next the scale of what is seen is
/// taken to drift a little, together with the speed, so that what the floor says corrects both (Ekf::let_scale_drift).
/// It needs a map whose unit may be chosen: a map that was loaded has one of its own.
/// Not in the seeds.
class FloorReckoning {
 public:
  enum class Verdict {
    kSilent,        ///< the floor told nothing
    kBelieved,      ///< the filter was corrected
    kRefused,       ///< the filter knows better
    kContradicted,  ///< the filter has known better for too long: corrected, and what is seen should be mapped anew
    kWrongGuess  ///< the map has only begun, its depths and so its unit a guess: corrected, all should be mapped anew
  };

  FloorReckoning(const FloorSpeedOptions& options, std::size_t cameras) : options_(options), speed_(options, cameras) {}

  /// Whether the floor told the speed lately, so that it is metres the filter counts in.
  bool tells_metres(common::Nanoseconds stamp) const;
  /// Lets the filter's idea of the scale age by the step to an image with these landmarks.
  void age(Ekf& filter, std::span<const LandmarkId> landmarks, double seconds) const;
  /// Corrects the filter's speed by what is seen.
  Verdict read(Ekf& filter, const FloorView& view);
  /// The robot has moved as the filter says, and nothing new is to be seen.
  void skip(const Ekf& filter, double seconds);

 private:
  TurnByWay turn(const Ekf& filter, const FloorView& view) const;
  Verdict judge(Ekf& filter, const FloorSpeed::Reading& reading, common::Nanoseconds stamp);

  FloorSpeedOptions options_;
  FloorSpeed speed_;
  double turn_rate_ = 0.0;                             // of the last step [rad/s]
  std::optional<common::Nanoseconds> begun_;           // to see something
  std::optional<common::Nanoseconds> believed_;        // last
  std::optional<common::Nanoseconds> refused_;         // last ...
  std::optional<common::Nanoseconds> refusing_since_;  // ... and first of those in a row
  int refusals_ = 0;                                   // in a row
  bool skipped_ = false;                               // the last image
};

}  // namespace slamfuse::visual_slam
