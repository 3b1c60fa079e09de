// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/localization_monitor.hpp"

namespace slamfuse::laser_slam {

using common::TrackingState;

void LocalizationMonitor::lose() {
  state_ = TrackingState::kLost;
  hypothesis_.reset();
  held_ = 0.0;
  held_scans_ = 0;
  low_since_.reset();
}

void LocalizationMonitor::trust() {
  state_ = TrackingState::kUncertain;
  hypothesis_.reset();
  low_since_.reset();
}

void LocalizationMonitor::add(const LocalizationEvidence& evidence) {
  const TrackingState before = state_;
  // What was good may become a little worse before it is doubted.
  const double least = before == TrackingState::kTracking ? options_.uncertain_agreement : options_.good_agreement;
  const bool good =
      evidence.agreement >= least && evidence.mass >= options_.sure_mass && evidence.spread <= options_.widest_spread;
  if (state_ == TrackingState::kLost) {
    search(evidence, good);
  } else {
    watch(evidence, good);
  }
  just_lost_ = before != TrackingState::kLost && state_ == TrackingState::kLost;
  just_found_ = before == TrackingState::kLost && state_ != TrackingState::kLost;
}

void LocalizationMonitor::search(const LocalizationEvidence& evidence, bool good) {
  const bool same = hypothesis_ == evidence.hypothesis;
  hypothesis_ = evidence.hypothesis;
  held_ = good && same ? held_ + evidence.driven : 0.0;
  held_scans_ = good && same ? held_scans_ + 1 : 0;
  if (held_ >= options_.confirm_distance && held_scans_ >= options_.confirm_scans) state_ = TrackingState::kTracking;
}

void LocalizationMonitor::watch(const LocalizationEvidence& evidence, bool good) {
  if (hypothesis_ && *hypothesis_ != evidence.hypothesis) return lose();
  hypothesis_ = evidence.hypothesis;
  if (evidence.agreement >= options_.lost_agreement) {
    low_since_.reset();
  } else if (!low_since_ || *low_since_ > evidence.stamp) {
    low_since_ = evidence.stamp;
  }
  if (low_since_ && common::to_seconds(evidence.stamp - *low_since_) >= options_.lost_time) return lose();
  state_ = good ? TrackingState::kTracking : TrackingState::kUncertain;
}

}  // namespace slamfuse::laser_slam
