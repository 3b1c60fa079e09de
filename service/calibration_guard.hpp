// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>

#include "common/ros_messages.hpp"

namespace slamfuse::service {

/// Watches whether cameras keep the calibration that is worked with. Pictures of a camera that tells another one cannot
/// be used, since nobody knows which of the two they were taken with; one that tells nothing else for a second was
/// started anew, or set otherwise.
class CalibrationGuard {
 public:
  using Arrival = std::chrono::steady_clock::time_point;

  /// Judges what a camera tells against what is `known`: whether it is the same calibration (size, distortion, K and
  /// D), to the last digit as drivers repeat it. Where frames and stamps differ is no matter.
  bool judge(const std::string& camera, const common::RosCameraInfo& known, const common::RosCameraInfo& told,
             Arrival arrival);
  /// Whether the last camera_info of this camera told another calibration.
  bool doubts(const std::string& camera) const { return changes_.contains(camera); }
  /// The newest calibration told, when for a second up to now nothing was told but others than the known one.
  std::optional<common::RosCameraInfo> insisted_on(const std::string& camera, Arrival now) const;
  /// What comes next is compared with calibrations that may be others.
  void reset() { changes_.clear(); }

 private:
  struct Change {
    Arrival since;
    common::RosCameraInfo told;  // the newest one
  };
  std::map<std::string, Change> changes_;  // by camera
};

}  // namespace slamfuse::service
