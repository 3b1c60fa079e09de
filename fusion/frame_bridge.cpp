// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/frame_bridge.hpp"

#include "fusion/measurement_model.hpp"

namespace slamfuse::fusion {

std::optional<Eigen::Vector3d> FrameBridge::use(const std::optional<Alignment>& alignment) {
  std::optional<Eigen::Vector3d> step;
  if (alignment && alignment_ && last_visual_) {
    step = difference(alignment->to_laser(*last_visual_), alignment_->to_laser(*last_visual_));
  }
  alignment_ = alignment;
  return step;
}

std::optional<UncertainPose> FrameBridge::to_laser(const UncertainPose& visual) {
  if (!alignment_) return std::nullopt;
  last_visual_ = visual.pose;
  UncertainPose aligned = aligned_pose(visual, *alignment_);
  aligned.covariance += alignment_error(*alignment_, visual.pose.translation());
  return aligned;
}

std::optional<UncertainPose> FrameBridge::to_visual(const UncertainPose& laser, bool is_bend_known) const {
  if (!alignment_) return std::nullopt;
  UncertainPose widened = laser;
  if (!is_bend_known) {
    widened.covariance += alignment_error(*alignment_, alignment_->to_visual(laser.pose).translation());
  }
  return visual_pose(widened, *alignment_);
}

}  // namespace slamfuse::fusion
