// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/time.hpp"
#include "visual_slam/state.hpp"

namespace slamfuse::visual_slam {

/// A past pose of base_link that is still estimated.
struct PastPose {
  BlockId block = 0;
  common::Nanoseconds stamp = 0;
  bool keyframe = false;  ///< stays for the final trajectory; others go with the last landmark anchored there
  int anchored = 0;       ///< landmarks whose inverse depth refers to it
};

/// The past poses in the filter's state: those landmarks hang on by inverse depth, and the keyframes. One moment has
/// one pose, whoever wants it.
class PastPoses {
 public:
  /// By rising stamp.
  const std::vector<PastPose>& all() const { return poses_; }
  /// The keyframe of that stamp; null when there is none.
  const PastPose* keyframe_at(common::Nanoseconds stamp) const;

  /// The robot's pose may have changed: it is not the newest past pose any more.
  void robot_moved() { moved_ = true; }
  /// The robot's pose now, entered into the state unless it is there, with one more landmark anchored at it.
  BlockId anchor(State& state, BlockId robot, common::Nanoseconds stamp);
  /// A landmark anchored at the pose is so no longer.
  void release(BlockId block);
  /// The robot's pose now becomes a keyframe.
  void add_keyframe(State& state, BlockId robot, common::Nanoseconds stamp);
  /// Over `most` keyframes the one whose neighbours are nearest to each other in time, never the first or the last, is
  /// none any more. Returns whether that happened.
  bool limit_keyframes(int most);
  /// The blocks of the poses nobody needs any more, which are forgotten here: they are to be removed from the state.
  std::vector<BlockId> take_needless();

 private:
  PastPose& now(State& state, BlockId robot, common::Nanoseconds stamp);

  std::vector<PastPose> poses_;
  bool moved_ = true;  // since the newest was taken
};

}  // namespace slamfuse::visual_slam
