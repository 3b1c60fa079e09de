// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/correction_limiter.hpp"

#include <algorithm>
#include <cmath>

#include "common/angle.hpp"

namespace slamfuse::fusion {
namespace {

/// The part of `missing` that may be made up for now: all of it when it is small, else what `rate` allows in `seconds`.
double part_allowed(double missing, double immediate, double rate, double seconds) {
  return missing <= std::max(immediate, rate * seconds) ? 1.0 : rate * seconds / missing;
}

}  // namespace

UncertainPose CorrectionLimiter::follow(common::Nanoseconds stamp, const UncertainPose& target,
                                        const common::Pose2& T_odom_base) {
  if (!started_) {
    started_ = true;
    settled_ = true;
    published_ = target.pose;
    speed_ = options_.speed;
    turn_rate_ = options_.turn_rate;
  } else {
    const double seconds = std::max(0.0, common::to_seconds(stamp - stamp_));
    const common::Pose2 moved = published_ * (T_odom_base_.inverse() * T_odom_base);
    const Eigen::Vector3d missing = difference(target.pose, moved);
    const double distance = missing.head<2>().norm();
    const double turn = std::abs(missing.z());
    // A transition under way keeps its speed until it is done.
    speed_ = std::max({options_.speed, distance / options_.settling_time, settled_ ? 0.0 : speed_});
    turn_rate_ = std::max({options_.turn_rate, turn / options_.settling_time, settled_ ? 0.0 : turn_rate_});
    const double step = part_allowed(distance, options_.immediate_distance, speed_, seconds);
    const double turn_step = part_allowed(turn, options_.immediate_turn, turn_rate_, seconds);
    settled_ = step == 1.0 && turn_step == 1.0;
    published_ = {moved.x + step * missing.x(), moved.y + step * missing.y(),
                  common::normalize_angle(moved.theta + turn_step * missing.z())};
  }
  stamp_ = std::max(stamp_, stamp);
  T_odom_base_ = T_odom_base;
  const Eigen::Vector3d behind = difference(target.pose, published_);
  lag_ = behind.head<2>().norm();
  return {published_, target.covariance + behind * behind.transpose()};
}

}  // namespace slamfuse::fusion
