// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <map>
#include <string>

#include "common/ros_messages.hpp"

namespace slamfuse::service {

/// Watches whether cameras keep the calibration that is worked with. Pictures of a camera that tells another one cannot
/// be used, since nobody knows which of the two they were taken with; one that tells the same other one for a second
/// was started anew, or set otherwise. Where calibrations keep varying none is believed: sessions would follow on each
/// other for ever.
class CalibrationGuard {
 public:
  using Arrival = std::chrono::steady_clock::time_point;

  /// Judges what a camera tells against what is `known`: whether it is the same calibration (size, distortion, K and
  /// D), to the last digit as drivers repeat it. Where frames and stamps differ is no matter.
  bool judge(const std::string& camera, const common::RosCameraInfo& known, const common::RosCameraInfo& told,
             Arrival arrival);
  /// Whether the last camera_info of this camera told another calibration.
  bool doubts(const std::string& camera) const { return changes_.contains(camera); }
  /// The calibrations, by camera, that are to be worked with from now on, and in doubt no longer: as soon as a camera
  /// has told the same one for a second, of all cameras that have for half a second. The cameras of a pair change
  /// together, and are to need one new session, not two. A camera may tell its calibration only once.
  std::map<std::string, common::RosCameraInfo> take_insisted(Arrival now);

 private:
  struct Change {
    Arrival since;
    common::RosCameraInfo told;
  };
  std::map<std::string, Change> changes_;  // by camera
};

}  // namespace slamfuse::service
