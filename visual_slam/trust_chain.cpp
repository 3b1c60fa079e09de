// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/trust_chain.hpp"

#include <algorithm>

namespace slamfuse::visual_slam {

bool TrustChain::see(std::span<const LandmarkId> landmarks) {
  if (!watching_) return true;
  const auto known =
      std::count_if(landmarks.begin(), landmarks.end(), [this](LandmarkId id) { return trusted_.contains(id); });
  if (known < enough_) return false;
  trusted_.insert(landmarks.begin(), landmarks.end());
  return true;
}

}  // namespace slamfuse::visual_slam
