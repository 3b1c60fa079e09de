// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "common/pose2.hpp"

namespace slamfuse::laser_slam {

/// Where each particle was at each filter update, and which particle of the update before it came from.
class Ancestry {
 public:
  struct Node {
    common::Pose2 pose;  ///< T_map_base at the update
    int parent = 0;      ///< index in the update before; not used in the first
  };

  void clear() { updates_.clear(); }
  void record(std::vector<Node> particles) { updates_.push_back(std::move(particles)); }
  std::size_t size() const { return updates_.size(); }

  /// The path, one pose an update, that ends in `particle` of the last update.
  std::vector<common::Pose2> path_of(int particle) const;

 private:
  std::vector<std::vector<Node>> updates_;
};

}  // namespace slamfuse::laser_slam
