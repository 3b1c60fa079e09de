// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/pose3.hpp"

namespace slamfuse::common {

/// Where the frames of a robot stand to each other, as ROS's tf tells it: every frame has one parent. The first pose
/// told of a frame counts, so what is asked for must not move: the mounting of a sensor, not the robot in its map.
class FrameTree {
 public:
  /// Does nothing when the frame is known already, or would become its own ancestor.
  void add(const std::string& parent, const std::string& child, const Pose3& T_parent_child);
  /// How many frames have a parent.
  std::size_t size() const { return links_.size(); }
  /// Whether a frame was named, as parent or as child.
  bool knows(const std::string& frame) const;
  /// T_target_source, the pose of frame `source` in frame `target`. Returns nothing when the two do not hang together.
  std::optional<Pose3> transform(const std::string& target, const std::string& source) const;

 private:
  struct Link {
    std::string parent;
    Pose3 T_parent_child;
  };
  /// The frames from this one up to the root with its pose in each.
  std::vector<std::pair<std::string, Pose3>> ancestors(const std::string& frame) const;

  std::map<std::string, Link> links_;  ///< by child
};

}  // namespace slamfuse::common
