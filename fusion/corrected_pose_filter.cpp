// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/corrected_pose_filter.hpp"

#include <cmath>

namespace slamfuse::fusion {

void CorrectedPoseFilter::restart() {
  started_ = false;
  supports_.clear();
  watches_.clear();
}

void CorrectedPoseFilter::move_to(const common::Pose2& T_odom_base, double seconds_without_odometry) {
  if (started_) {
    state_ = moved(state_, T_odom_base_.inverse() * T_odom_base, seconds_without_odometry, options_.drift);
  }
  T_odom_base_ = T_odom_base;
}

void CorrectedPoseFilter::change_odometry_frame(const common::Pose2& T_new_old) {
  T_odom_base_ = T_new_old * T_odom_base_;
  for (auto& [source, support] : supports_) support.T_odom_base = T_new_old * support.T_odom_base;
  for (auto& [source, watch] : watches_) watch.change_odometry_frame(T_new_old);
}

MeasurementReport CorrectedPoseFilter::measure(common::PoseSource source, common::Nanoseconds stamp,
                                               const UncertainPose& measured, const common::Pose2& T_odom_base_then,
                                               double seconds_without_odometry) {
  const UncertainPose now =
      moved(measured, T_odom_base_then.inverse() * T_odom_base_, seconds_without_odometry, options_.drift);
  const Support support{stamp, now, T_odom_base_};
  MeasurementReport report;
  if (!started_) {
    started_ = true;
    state_ = now;
    supports_[source] = support;
    report.outcome = MeasurementOutcome::kStarted;
    return report;
  }
  report.squared_distance = squared_distance(state_, now);
  DisagreementWatch& watch = watches_.try_emplace(source, options_.disagreement).first->second;
  if (report.squared_distance <= options_.gate) {
    state_ = intersect(state_, now);
    supports_[source] = support;
    watch.clear();
    report.outcome = MeasurementOutcome::kFused;
    return report;
  }
  if (!watch.persists(stamp, now, T_odom_base_, options_.gate, options_.drift)) return report;
  if (other_speaks_against(source, stamp, now)) {
    report.outcome = MeasurementOutcome::kOverruled;
    return report;
  }
  report.outcome = MeasurementOutcome::kAdopted;
  report.jump = (now.pose.translation() - state_.pose.translation()).norm();
  state_ = now;
  supports_.clear();
  supports_[source] = support;
  watch.clear();
  return report;
}

bool CorrectedPoseFilter::other_speaks_against(common::PoseSource source, common::Nanoseconds stamp,
                                               const UncertainPose& candidate) const {
  for (const auto& [other, support] : supports_) {
    if (other == source || std::abs(common::to_seconds(stamp - support.stamp)) > options_.support_memory) continue;
    const UncertainPose now = moved(support.pose, support.T_odom_base.inverse() * T_odom_base_, 0.0, options_.drift);
    if (squared_distance(candidate, now) > options_.gate) return true;
  }
  return false;
}

}  // namespace slamfuse::fusion
