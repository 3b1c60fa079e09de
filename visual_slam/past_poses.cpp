// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/past_poses.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "visual_slam/pose_block.hpp"

namespace slamfuse::visual_slam {

const PastPose* PastPoses::keyframe_at(common::Nanoseconds stamp) const {
  const auto found = std::find_if(poses_.begin(), poses_.end(),
                                  [stamp](const PastPose& past) { return past.keyframe && past.stamp == stamp; });
  return found == poses_.end() ? nullptr : &*found;
}

PastPose& PastPoses::now(State& state, BlockId robot, common::Nanoseconds stamp) {
  if (poses_.empty() || moved_ || poses_.back().stamp != stamp) {
    const BlockId block = append_copy(state, robot);
    poses_.push_back({.block = block, .stamp = stamp, .keyframe = false, .anchored = 0});
    moved_ = false;
  }
  return poses_.back();
}

BlockId PastPoses::anchor(State& state, BlockId robot, common::Nanoseconds stamp) {
  PastPose& pose = now(state, robot, stamp);
  ++pose.anchored;
  return pose.block;
}

void PastPoses::release(BlockId block) {
  --std::find_if(poses_.begin(), poses_.end(), [block](const PastPose& past) { return past.block == block; })->anchored;
}

void PastPoses::add_keyframe(State& state, BlockId robot, common::Nanoseconds stamp) {
  now(state, robot, stamp).keyframe = true;
}

bool PastPoses::limit_keyframes(int most) {
  std::vector<PastPose*> keyframes;
  for (PastPose& past : poses_) {
    if (past.keyframe) keyframes.push_back(&past);
  }
  if (static_cast<int>(keyframes.size()) <= most) return false;
  std::size_t spare = 1;
  common::Nanoseconds shortest = std::numeric_limits<common::Nanoseconds>::max();
  for (std::size_t i = 1; i + 1 < keyframes.size(); ++i) {
    const common::Nanoseconds gap = keyframes[i + 1]->stamp - keyframes[i - 1]->stamp;
    if (gap < shortest) {
      shortest = gap;
      spare = i;
    }
  }
  keyframes[spare]->keyframe = false;
  return true;
}

std::vector<BlockId> PastPoses::take_needless() {
  std::vector<BlockId> blocks;
  std::erase_if(poses_, [&blocks](const PastPose& past) {
    const bool needless = !past.keyframe && past.anchored == 0;
    if (needless) blocks.push_back(past.block);
    return needless;
  });
  return blocks;
}

}  // namespace slamfuse::visual_slam
