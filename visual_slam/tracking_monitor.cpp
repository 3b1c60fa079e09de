// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/tracking_monitor.hpp"

#include <limits>

namespace slamfuse::visual_slam {
namespace {

constexpr int kClearMajority = 2;  // so many times the features of a good image must have been expected to miss them

}  // namespace

bool TrackingMonitor::asks_for_texture(const ImageEvidence& image) const {
  return !contradicted_ && !is_good(image) && image.expected >= kClearMajority * options_.min_inliers;
}

common::TrackingState TrackingMonitor::update(common::Nanoseconds stamp, const ImageEvidence& image) {
  const bool good = is_good(image);
  if (!started_ || good) {
    started_ = true;
    last_good_ = stamp;
  }
  if (good) {
    confirmed_ = true;
    contradicted_ = false;
  } else if (asks_for_texture(image) && image.textured) {
    contradicted_ = true;
  }
  const double blind = common::to_seconds(stamp - last_good_);
  if (blind > (contradicted_ ? options_.uncertain_after : options_.lost_after)) {
    state_ = common::TrackingState::kLost;
  } else if (blind > options_.uncertain_after || contradicted_ || !confirmed_ || image.doubted) {
    state_ = common::TrackingState::kUncertain;
  } else {
    state_ = common::TrackingState::kTracking;
  }
  return state_;
}

void TrackingMonitor::pose_was_set() {
  started_ = false;
  confirmed_ = false;
  contradicted_ = false;
  state_ = common::TrackingState::kUncertain;
}

void TrackingMonitor::lose() {
  started_ = true;
  contradicted_ = true;
  last_good_ = std::numeric_limits<common::Nanoseconds>::min() / 2;
  state_ = common::TrackingState::kLost;
}

}  // namespace slamfuse::visual_slam
