// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/localization_path.hpp"

#include <span>

namespace slamfuse::laser_slam {

void LocalizationPath::Chain::operator()(Step& next, const Step& gone) const {
  next.increment = gone.increment * next.increment;
}

void LocalizationPath::add(const Entry& entry, const common::Pose2& increment) {
  steps_.push({entry, increment, steps_.count()});
}

void LocalizationPath::lost() {
  const std::span<Step> steps = steps_.changeable();
  for (auto step = steps.rbegin(); step != steps.rend() && !step->good; ++step) step->known = false;
}

void LocalizationPath::found_since(std::size_t moment) {
  const std::span<Step> steps = steps_.changeable();
  if (steps.empty()) return;
  const int found = steps.back().hypothesis;
  steps.back().known = true;
  for (std::size_t i = steps.size() - 1; i-- > 0 && steps[i].number >= moment;) {
    Entry& entry = steps[i];
    if (entry.known) continue;
    const bool matched = entry.hypothesis == found && entry.good;
    if (!matched) entry.pose = steps[i + 1].pose * steps[i + 1].increment.inverse();
    entry.known = true;
  }
}

common::Trajectory2 LocalizationPath::trajectory() const {
  common::Trajectory2 result;
  for (const Step& step : steps_.items()) {
    if (step.known) result.push_back({step.stamp, step.pose});
  }
  return result;
}

}  // namespace slamfuse::laser_slam
