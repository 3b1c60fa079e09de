// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/frame_bridge.hpp"

#include <algorithm>

#include "common/angle.hpp"
#include "fusion/measurement_model.hpp"

namespace slamfuse::fusion {
namespace {

constexpr common::Nanoseconds kMemory = 3 * common::kNanosecondsPerSecond;
/// A laser pose this far in time from a visual one still belongs to the same moment, moved by odometry.
constexpr common::Nanoseconds kSameMoment = common::kNanosecondsPerSecond / 2;

}  // namespace

void FrameBridge::forget_place() {
  told_.clear();
  last_visual_.reset();
  place_known_ = false;
  laser_covariance_.setZero();
}

void FrameBridge::use(const std::optional<Alignment>& alignment) {
  if (alignment && alignment_ && last_visual_ && place_known_) {
    const common::Pose2& here = last_visual_->pose.pose;
    const Eigen::Vector3d step = difference(alignment->to_laser(here), alignment_->to_laser(here));
    alignment_ = alignment;
    bend_.realign(step, spread(here));
    return;
  }
  alignment_ = alignment;
  forget_place();
}

void FrameBridge::change_odometry_frame(const common::Pose2& T_new_old) {
  for (Told& told : told_) told.T_odom_base = T_new_old * told.T_odom_base;
  if (last_visual_) last_visual_->T_odom_base = T_new_old * last_visual_->T_odom_base;
}

void FrameBridge::laser_told(common::Nanoseconds stamp, const UncertainPose& laser, const common::Pose2& T_odom_base) {
  std::erase_if(told_, [&](const Told& told) { return std::abs(stamp - told.stamp) > kMemory; });
  told_.push_back({stamp, laser, T_odom_base});
}

std::optional<UncertainPose> FrameBridge::laser_at(common::Nanoseconds stamp, const common::Pose2& T_odom_base) const {
  const auto nearest = std::min_element(told_.begin(), told_.end(), [&](const Told& a, const Told& b) {
    return std::abs(a.stamp - stamp) < std::abs(b.stamp - stamp);
  });
  if (nearest == told_.end() || std::abs(nearest->stamp - stamp) > kSameMoment) return std::nullopt;
  return moved(nearest->pose, nearest->T_odom_base.inverse() * T_odom_base, 0.0, drift_);
}

std::optional<UncertainPose> FrameBridge::to_laser(common::Nanoseconds stamp, const UncertainPose& visual,
                                                   const common::Pose2& T_odom_base, double gate) {
  if (!alignment_) return std::nullopt;
  if (!place_known_) {
    bend_.restart(spread(visual.pose));
    place_known_ = true;
  } else if (last_visual_) {
    bend_.move((last_visual_->T_odom_base.inverse() * T_odom_base).translation().norm());
  }
  last_visual_ = Told{stamp, visual, T_odom_base};
  const UncertainPose aligned = aligned_pose(visual, *alignment_);
  if (const auto laser = laser_at(stamp, T_odom_base)) {
    const Eigen::Vector3d residual = difference(laser->pose, aligned.pose);
    if (bend_.update(residual, laser->covariance + aligned.covariance, gate)) laser_covariance_ = laser->covariance;
  }
  UncertainPose corrected = bend_.correct(aligned);
  // The bend was measured against laser poses that share the errors of their map: the mean of many is no better than
  // one.
  corrected.covariance += laser_covariance_;
  return corrected;
}

std::optional<UncertainPose> FrameBridge::to_visual(const UncertainPose& laser) const {
  if (!alignment_) return std::nullopt;
  UncertainPose straight = laser;
  if (place_known_) {
    straight.pose = {laser.pose.x - bend_.bend().x(), laser.pose.y - bend_.bend().y(),
                     common::normalize_angle(laser.pose.theta - bend_.bend().z())};
    straight.covariance += bend_.covariance();
  } else {
    straight.covariance += spread(alignment_->to_visual(laser.pose));
  }
  return visual_pose(straight, *alignment_);
}

Eigen::Matrix3d FrameBridge::spread(const common::Pose2& visual) const {
  return alignment_error(*alignment_, visual.translation());
}

}  // namespace slamfuse::fusion
