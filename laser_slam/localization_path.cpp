// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/localization_path.hpp"

namespace slamfuse::laser_slam {

void LocalizationPath::add(const Entry& entry, const common::Pose2& increment) {
  entries_.push_back(entry);
  increments_.push_back(increment);
}

void LocalizationPath::lost() {
  for (auto entry = entries_.rbegin(); entry != entries_.rend() && !entry->good; ++entry) entry->known = false;
}

void LocalizationPath::found_since(std::size_t moment) {
  if (entries_.empty()) return;
  const int found = entries_.back().hypothesis;
  entries_.back().known = true;
  for (std::size_t i = entries_.size() - 1; i-- > moment;) {
    Entry& entry = entries_[i];
    if (entry.known) continue;
    const bool matched = entry.hypothesis == found && entry.good;
    if (!matched) entry.pose = entries_[i + 1].pose * increments_[i + 1].inverse();
    entry.known = true;
  }
}

void LocalizationPath::clear() {
  entries_.clear();
  increments_.clear();
}

common::Trajectory2 LocalizationPath::trajectory() const {
  common::Trajectory2 result;
  for (const Entry& entry : entries_) {
    if (entry.known) result.push_back({entry.stamp, entry.pose});
  }
  return result;
}

}  // namespace slamfuse::laser_slam
