// SPDX-License-Identifier: BSD-3-Clause
#include "common/frame_tree.hpp"

#include <algorithm>

namespace slamfuse::common {

void FrameTree::add(const std::string& parent, const std::string& child, const Pose3& T_parent_child) {
  const auto above = ancestors(parent);
  const bool loop = std::any_of(above.begin(), above.end(), [&](const auto& frame) { return frame.first == child; });
  if (!loop) links_.try_emplace(child, Link{parent, T_parent_child});
}

bool FrameTree::knows(const std::string& frame) const {
  return links_.contains(frame) ||
         std::any_of(links_.begin(), links_.end(), [&](const auto& link) { return link.second.parent == frame; });
}

std::optional<Pose3> FrameTree::transform(const std::string& target, const std::string& source) const {
  const auto above_target = ancestors(target);
  for (const auto& [frame, T_frame_source] : ancestors(source)) {
    for (const auto& [other, T_other_target] : above_target) {
      if (frame == other) return T_other_target.inverse() * T_frame_source;
    }
  }
  return std::nullopt;
}

std::vector<std::pair<std::string, Pose3>> FrameTree::ancestors(const std::string& frame) const {
  std::vector<std::pair<std::string, Pose3>> above{{frame, Pose3{}}};
  for (auto link = links_.find(frame); link != links_.end(); link = links_.find(link->second.parent)) {
    above.emplace_back(link->second.parent, link->second.T_parent_child * above.back().second);
  }
  return above;
}

}  // namespace slamfuse::common
