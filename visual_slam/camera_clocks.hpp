// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/sensor_message.hpp"
#include "common/time.hpp"
#include "visual_slam/camera_tracks.hpp"
#include "visual_slam/image_backlog.hpp"
#include "visual_slam/image_clock.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// The clocks of all cameras against that of the wheel odometry, and the images a map could be made anew from while one
/// of them may turn out wrong.
class CameraClocks {
 public:
  /// The cameras must stay where they are as long as their clocks.
  CameraClocks(const ImageClockOptions& options, const TurnSearchOptions& search,
               const std::vector<CameraTracks>& cameras);

  void add(const common::WheelOdometry& odometry);
  /// Looks at the next image of a camera, which must have the size its calibration says. Returns the cameras whose
  /// corrections have changed: then what was estimated from the images kept() was by wrong stamps.
  std::vector<std::size_t> watch(std::size_t camera, const common::Image& image);
  /// Keeps an image while a correction may still change; once none may, nothing is kept.
  void keep(const common::Image& image);
  /// What has to be added to a camera's stamps.
  common::Nanoseconds correction(std::size_t camera) const { return clocks_[camera].correction(); }
  /// The images kept, with their stamps as they are believed now and in the order of these; of equal ones the first to
  /// come is first.
  std::vector<common::Image> kept() const;
  /// The earliest stamp of an image kept, as it is believed now or was before the last change. There must be one.
  common::Nanoseconds first_kept() const;
  /// Whether a correction may still change.
  bool may_change() const;
  /// The map does not go on from the images kept so far (a reset, a pose set from outside).
  void forget_kept() { backlog_.clear(); }

 private:
  std::size_t index_of(const common::Image& image) const;

  std::vector<std::string> names_;           // of the cameras
  std::vector<ImageClock> clocks_;           // as names_
  std::vector<common::Nanoseconds> before_;  // the corrections before the last change
  ImageBacklog backlog_;
};

}  // namespace slamfuse::visual_slam
