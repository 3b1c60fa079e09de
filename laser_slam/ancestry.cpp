// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/ancestry.hpp"

namespace slamfuse::laser_slam {

std::vector<common::Pose2> Ancestry::path_of(int particle) const {
  std::vector<common::Pose2> path(updates_.size());
  for (std::size_t update = updates_.size(); update-- > 0;) {
    const Node& node = updates_[update][static_cast<std::size_t>(particle)];
    path[update] = node.pose;
    particle = node.parent;
  }
  return path;
}

}  // namespace slamfuse::laser_slam
