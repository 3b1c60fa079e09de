// SPDX-License-Identifier: BSD-3-Clause
#include "service/calibration_guard.hpp"

#include <algorithm>

namespace slamfuse::service {
namespace {

/// So long a camera has to insist on another calibration.
constexpr std::chrono::milliseconds kPatience{1000};
/// So long when another one's changes as well.
constexpr std::chrono::milliseconds kPatienceInCompany{500};

bool same_calibration(const common::RosCameraInfo& one, const common::RosCameraInfo& other) {
  return one.width == other.width && one.height == other.height && one.distortion_model == other.distortion_model &&
         one.d == other.d && one.k == other.k;
}

}  // namespace

bool CalibrationGuard::judge(const std::string& camera, const common::RosCameraInfo& known,
                             const common::RosCameraInfo& told, Arrival arrival) {
  if (same_calibration(told, known)) {
    changes_.erase(camera);
    return true;
  }
  const auto [change, is_first] = changes_.try_emplace(camera, Change{arrival, told});
  if (!is_first && !same_calibration(told, change->second.told)) change->second = {arrival, told};
  return false;
}

std::map<std::string, common::RosCameraInfo> CalibrationGuard::take_insisted(Arrival now) {
  const auto stands_for = [now](std::chrono::milliseconds patience) {
    return [=](const auto& change) { return now - change.second.since >= patience; };
  };
  std::map<std::string, common::RosCameraInfo> insisted;
  if (std::ranges::none_of(changes_, stands_for(kPatience))) return insisted;
  for (const auto& [camera, change] : changes_) {
    if (now - change.since >= kPatienceInCompany) insisted.emplace(camera, change.told);
  }
  std::erase_if(changes_, stands_for(kPatienceInCompany));
  return insisted;
}

}  // namespace slamfuse::service
