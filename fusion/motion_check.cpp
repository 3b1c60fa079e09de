// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/motion_check.hpp"

#include <cmath>

namespace slamfuse::fusion {

namespace {

/// Once it was not plausible the motion must fit this much better to be so again.
constexpr double kHysteresis = 3.0;

UncertainPose scaled(UncertainPose pose, double scale) {
  const Eigen::Vector3d factors(scale, scale, 1.0);
  pose.pose.x *= scale;
  pose.pose.y *= scale;
  pose.covariance = factors.asDiagonal() * pose.covariance * factors.asDiagonal();
  return pose;
}

}  // namespace

void MotionCheck::add(common::Nanoseconds stamp, const UncertainPose& pose, double scale,
                      const common::Pose2& T_odom_base) {
  const common::Nanoseconds window = common::from_seconds(options_.window);
  // A stamp that steps back, or a silence, begins anew.
  if (!steps_.empty() && (stamp < steps_.back().stamp || stamp - steps_.back().stamp > window)) forget();
  if (!steps_.empty() && stamp == steps_.back().stamp) steps_.pop_back();
  steps_.push_back({stamp, pose, T_odom_base});
  while (steps_.size() > 2 && stamp - steps_[1].stamp >= window) steps_.pop_front();
  if (stamp - steps_.front().stamp < window) return;
  const UncertainPose first = scaled(steps_.front().pose, scale);
  const UncertainPose last = scaled(pose, scale);
  const UncertainPose by_wheels = moved(first, steps_.front().T_odom_base.inverse() * T_odom_base, 0.0, drift_);
  const double distance = squared_distance(by_wheels, last);
  plausible_ = distance <= (plausible_.value_or(true) ? options_.gate : options_.gate / kHysteresis);
  is_telling_ = squared_distance(by_wheels, {first.pose, last.covariance}) > options_.gate;
}

std::optional<bool> MotionCheck::plausible(common::Nanoseconds now) const {
  if (!plausible_ || std::abs(now - steps_.back().stamp) > common::from_seconds(options_.window)) {
    return std::nullopt;
  }
  return plausible_;
}

void MotionCheck::forget() {
  steps_.clear();
  plausible_.reset();
}

}  // namespace slamfuse::fusion
