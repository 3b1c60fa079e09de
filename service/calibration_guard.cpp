// SPDX-License-Identifier: BSD-3-Clause
#include "service/calibration_guard.hpp"

namespace slamfuse::service {
namespace {

/// So long a camera has to insist on another calibration.
constexpr std::chrono::seconds kPatience{1};

}  // namespace

bool CalibrationGuard::judge(const std::string& camera, const common::RosCameraInfo& known,
                             const common::RosCameraInfo& told, Arrival arrival) {
  const bool same = told.width == known.width && told.height == known.height &&
                    told.distortion_model == known.distortion_model && told.d == known.d && told.k == known.k;
  if (same) {
    changes_.erase(camera);
  } else {
    changes_.try_emplace(camera, Change{arrival, told}).first->second.told = told;
  }
  return same;
}

std::optional<common::RosCameraInfo> CalibrationGuard::insisted_on(const std::string& camera, Arrival now) const {
  const auto change = changes_.find(camera);
  if (change == changes_.end() || now - change->second.since < kPatience) return std::nullopt;
  return change->second.told;
}

}  // namespace slamfuse::service
