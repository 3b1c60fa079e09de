// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/path_log.hpp"

namespace slamfuse::laser_slam {

void PathLog::clear() {
  entries_.clear();
  segments_.clear();
}

void PathLog::begin_segment(std::optional<common::Pose2> arrival) { segments_.push_back({arrival}); }

void PathLog::add(common::Nanoseconds stamp, const common::Pose2& since_update) {
  entries_.push({stamp, since_update, segments_.size() - 1, segments_.back().entries++});
}

common::Trajectory2 PathLog::compose(const std::vector<common::Pose2>& updates) const {
  common::Trajectory2 path;
  path.reserve(entries_.items().size());
  auto entry = entries_.items().begin();
  const auto end = entries_.items().end();
  for (std::size_t s = 0; s < segments_.size(); ++s) {
    const bool has_next = s + 1 < segments_.size();
    // What the next update's pose says beyond the online path, as a twist seen from its arrival.
    Eigen::Vector3d correction = Eigen::Vector3d::Zero();
    if (has_next && segments_[s + 1].arrival) {
      correction = common::log_se2((updates[s] * *segments_[s + 1].arrival).inverse() * updates[s + 1]);
    }
    for (; entry != end && entry->segment == s; ++entry) {
      // The segment's first entry is the update's own scan, at fraction 0; the next update's scan is at fraction 1.
      const double fraction = static_cast<double>(entry->place) / static_cast<double>(segments_[s].entries);
      path.push_back({entry->stamp, updates[s] * entry->since_update * common::exp_se2(correction * fraction)});
    }
  }
  return path;
}

}  // namespace slamfuse::laser_slam
