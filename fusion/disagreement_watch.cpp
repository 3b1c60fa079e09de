// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/disagreement_watch.hpp"

namespace slamfuse::fusion {

bool DisagreementWatch::persists(common::Nanoseconds stamp, const UncertainPose& gated,
                                 const common::Pose2& T_odom_base, double gate, const OdometryDriftOptions& drift) {
  const UncertainPose expected = moved(last_, last_T_odom_base_.inverse() * T_odom_base, 0.0, drift);
  if (count_ == 0 || squared_distance(expected, gated) > gate) {
    count_ = 0;
    first_stamp_ = stamp;
  }
  ++count_;
  last_ = gated;
  last_T_odom_base_ = T_odom_base;
  return count_ >= options_.poses && common::to_seconds(stamp - first_stamp_) >= options_.seconds;
}

}  // namespace slamfuse::fusion
