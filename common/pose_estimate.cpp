// SPDX-License-Identifier: BSD-3-Clause
#include "common/pose_estimate.hpp"

namespace slamfuse::common {

std::string to_string(PoseSource source) {
  switch (source) {
    case PoseSource::kOdometry:
      return "odometry";
    case PoseSource::kLaser:
      return "laser";
    case PoseSource::kVisual:
      return "visual";
    case PoseSource::kFused:
      return "fused";
  }
  return "unknown";
}

std::string to_string(TrackingState state) {
  switch (state) {
    case TrackingState::kTracking:
      return "TRACKING";
    case TrackingState::kUncertain:
      return "UNCERTAIN";
    case TrackingState::kLost:
      return "LOST";
  }
  return "UNKNOWN";
}

}  // namespace slamfuse::common
