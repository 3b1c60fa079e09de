// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/dead_reckoning.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr common::Nanoseconds kTwistInterval = 50'000'000;  // over which the speed is taken

}  // namespace

void DeadReckoning::predict(Ekf& filter, std::optional<common::Nanoseconds> since, common::Nanoseconds stamp) {
  const double seconds = since ? common::to_seconds(stamp - *since) : 0.0;
  if (!by_wheels_) {
    if (since) filter.predict({seconds, {}});
    twist_ = *filter.twist();
    pose_ = filter.pose();
    return;
  }
  const common::Pose2 now = *odometry_.pose_at(stamp);
  if (since) filter.predict({seconds, pose_.inverse() * now});
  const std::optional<common::Pose2> before = odometry_.pose_at(stamp - kTwistInterval);
  twist_ =
      before ? BodyTwist(common::log_se2(before->inverse() * now) / common::to_seconds(kTwistInterval)) : BodyTwist();
  pose_ = now;
}

void DeadReckoning::corrected(const Ekf& filter) {
  if (!by_wheels_) twist_ = *filter.twist();
}

void DeadReckoning::estimated(const Ekf& filter) {
  if (!by_wheels_) pose_ = filter.pose();
}

}  // namespace slamfuse::visual_slam
