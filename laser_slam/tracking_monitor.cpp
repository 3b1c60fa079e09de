// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/tracking_monitor.hpp"

namespace slamfuse::laser_slam {

void TrackingMonitor::add(common::Nanoseconds stamp, std::optional<double> agreement) {
  just_lost_ = false;
  just_found_ = false;
  if (!agreement) return;
  const bool was_lost = state_ == common::TrackingState::kLost;
  if (*agreement >= thresholds_.lost) {
    low_since_.reset();
    // Once lost, a scan that is merely doubtful does not make it found.
    if (was_lost && *agreement < thresholds_.uncertain) return;
    state_ = *agreement < thresholds_.uncertain ? common::TrackingState::kUncertain : common::TrackingState::kTracking;
    just_found_ = was_lost;
    return;
  }
  if (!low_since_ || *low_since_ > stamp) low_since_ = stamp;
  const bool lost = was_lost || common::to_seconds(stamp - *low_since_) >= thresholds_.lost_time;
  state_ = lost ? common::TrackingState::kLost : common::TrackingState::kUncertain;
  just_lost_ = lost && !was_lost;
}

void TrackingMonitor::reset() {
  state_ = common::TrackingState::kTracking;
  low_since_.reset();
  just_lost_ = false;
  just_found_ = false;
}

}  // namespace slamfuse::laser_slam
