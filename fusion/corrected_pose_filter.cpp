// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/corrected_pose_filter.hpp"

#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "common/angle.hpp"

namespace slamfuse::fusion {
namespace {

using common::PoseSource;
using Selection = Eigen::Matrix<double, 3, 9>;

/// A half's variances that are more than so many times what they were are another error, not another guess at the same:
/// from scan to scan they differ by less.
constexpr double kOtherSpread = 4.0;

/// Where there is no odometry the robot counts as driving this fast [m/s].
constexpr double kUnknownSpeed = 0.3;

/// First of the three rows of m in the state.
Eigen::Index row_of(PoseSource source) { return source == PoseSource::kLaser ? 3 : 6; }

common::Pose2 shifted(const common::Pose2& pose, const Eigen::Vector3d& by) {
  return {pose.x + by.x(), pose.y + by.y(), common::normalize_angle(pose.theta + by.z())};
}

/// x + m, what a half measures.
Selection measured_part(PoseSource source) {
  Selection part = Selection::Zero();
  part.leftCols<3>().setIdentity();
  part.middleCols<3>(row_of(source)).setIdentity();
  return part;
}

double squared_length(const Eigen::Vector3d& vector, const Eigen::Matrix3d& covariance) {
  return vector.dot(covariance.ldlt().solve(vector));
}

}  // namespace

CorrectedPoseFilter::CorrectedPoseFilter(const CorrectedPoseOptions& options)
    : options_(options), shared_(Eigen::Matrix3d::Zero()) {
  shared_(0, 0) = shared_(1, 1) = options.shared_position_sigma * options.shared_position_sigma;
  shared_(2, 2) = options.shared_heading_sigma * options.shared_heading_sigma;
}

UncertainPose CorrectedPoseFilter::expected(PoseSource source) const {
  const Selection part = measured_part(source);
  return {shifted(pose_, error_of(source).mean), part * covariance_ * part.transpose() + shared_};
}

void CorrectedPoseFilter::restart() {
  started_ = false;
  errors_ = {};
  covariance_.setZero();
  supports_.clear();
  watches_.clear();
}

void CorrectedPoseFilter::move_to(const common::Pose2& T_odom_base, double seconds_without_odometry) {
  if (started_) {
    const common::Pose2 step = T_odom_base_.inverse() * T_odom_base;
    const UncertainPose drifted =
        moved({pose_, Eigen::Matrix3d::Zero()}, step, seconds_without_odometry, options_.drift);
    Covariance transition = Covariance::Identity();
    transition.topLeftCorner<3, 3>() = common::compose_jacobians(pose_, step).wrt_a;
    const double distance = step.translation().norm() + kUnknownSpeed * seconds_without_odometry;
    const double kept = std::exp(-distance / options_.map_error.length);
    transition.bottomRightCorner<6, 6>() *= kept;
    covariance_ = transition * covariance_ * transition.transpose();
    covariance_.topLeftCorner<3, 3>() += drifted.covariance;
    for (const PoseSource source : {PoseSource::kLaser, PoseSource::kVisual}) {
      MapError& error = error_of(source);
      error.mean *= kept;
      covariance_.block<3, 3>(row_of(source), row_of(source)) += (1.0 - kept * kept) * error.spread;
    }
    pose_ = drifted.pose;
  }
  T_odom_base_ = T_odom_base;
}

void CorrectedPoseFilter::change_odometry_frame(const common::Pose2& T_new_old) {
  T_odom_base_ = T_new_old * T_odom_base_;
  for (auto& [source, support] : supports_) support.T_odom_base = T_new_old * support.T_odom_base;
  for (auto& [source, watch] : watches_) watch.change_odometry_frame(T_new_old);
}

void CorrectedPoseFilter::shift(PoseSource source, const Eigen::Vector3d& step) {
  MapError& error = error_of(source);
  if (!error.known) return;
  const Eigen::Index row = row_of(source);
  const Eigen::Vector3d mean = error.mean + step;
  if (squared_length(mean, covariance_.block<3, 3>(row, row) + error.spread + shared_) > options_.gate) {
    return reset_error(source);
  }
  error.mean = mean;
  covariance_.block<3, 3>(row, row) += step * step.transpose();
}

void CorrectedPoseFilter::forget(PoseSource source) {
  error_of(source) = {};
  reset_error(source);
  supports_.erase(source);
  watches_.erase(source);
}

MeasurementReport CorrectedPoseFilter::measure(PoseSource source, common::Nanoseconds stamp,
                                               const UncertainPose& measured, const common::Pose2& T_odom_base_then,
                                               double seconds_without_odometry, bool held_back) {
  const double share = options_.map_error.random_share;
  const common::Pose2 step = T_odom_base_then.inverse() * T_odom_base_;
  const UncertainPose drifted =
      moved({measured.pose, Eigen::Matrix3d::Zero()}, step, seconds_without_odometry, options_.drift);
  const UncertainPose carried = moved(measured, step, seconds_without_odometry, options_.drift);
  const Eigen::Matrix3d own = carried.covariance - drifted.covariance;
  const Eigen::Matrix3d random = share * own + drifted.covariance;
  const UncertainPose now{carried.pose, carried.covariance + shared_};
  MeasurementReport report;
  if (!started_) {
    error_of(source).spread = (1.0 - share) * own;
    start_at(source, now, random);
    supports_[source] = {stamp, now, T_odom_base_};
    report.outcome = MeasurementOutcome::kStarted;
    return report;
  }
  change_spread(source, (1.0 - share) * own);
  MapError& error = error_of(source);

  const Eigen::Vector3d innovation = difference(now.pose, expected(source).pose);
  // The gate asks whether the map's error can be what it takes, not whether it can have changed by that since the last
  // pose: a closed loop changes it at once.
  const Eigen::Matrix3d width = state().covariance + now.covariance;
  report.squared_distance = squared_length(innovation, width);
  const UncertainPose corrected{shifted(now.pose, -error.mean), now.covariance};
  DisagreementWatch& watch = watches_.try_emplace(source, options_.disagreement).first->second;
  if (report.squared_distance <= options_.gate) {
    watch.clear();
    if (held_back) {
      report.outcome = MeasurementOutcome::kHeldBack;
      return report;
    }
    update(source, innovation, random);
    supports_[source] = {stamp, corrected, T_odom_base_};
    report.outcome = MeasurementOutcome::kFused;
    return report;
  }
  if (!watch.persists(stamp, now, T_odom_base_, options_.gate, options_.drift)) return report;
  if (held_back || other_speaks_against(source, stamp, now)) {
    report.outcome = MeasurementOutcome::kOverruled;
    return report;
  }
  report.outcome = MeasurementOutcome::kAdopted;
  report.jump = (now.pose.translation() - pose_.translation()).norm();
  start_at(source, now, random);
  supports_.clear();
  supports_[source] = {stamp, now, T_odom_base_};
  watch.clear();
  return report;
}

void CorrectedPoseFilter::start_at(PoseSource source, const UncertainPose& measured, const Eigen::Matrix3d& random) {
  // x = z - m - v.
  started_ = true;
  pose_ = measured.pose;
  const Eigen::Matrix3d spread = error_of(source).spread;
  errors_ = {};
  error_of(source) = {true, Eigen::Vector3d::Zero(), spread, spread};
  covariance_.setZero();
  covariance_.topLeftCorner<3, 3>() = spread + random;
  covariance_.block<3, 3>(row_of(source), row_of(source)) = spread;
  covariance_.block<3, 3>(0, row_of(source)) = -spread;
  covariance_.block<3, 3>(row_of(source), 0) = -spread;
}

void CorrectedPoseFilter::update(PoseSource source, const Eigen::Vector3d& innovation, const Eigen::Matrix3d& random) {
  const Selection part = measured_part(source);
  const Eigen::Matrix3d width = part * covariance_ * part.transpose() + random;
  const Eigen::Matrix<double, 9, 3> gain = width.ldlt().solve(part * covariance_).transpose();
  const Eigen::Matrix<double, 9, 1> step = gain * innovation;
  pose_ = shifted(pose_, step.head<3>());
  errors_[0].mean += step.segment<3>(3);
  errors_[1].mean += step.segment<3>(6);
  // Joseph's form keeps the covariance positive definite.
  const Covariance kept = Covariance::Identity() - gain * part;
  covariance_ = kept * covariance_ * kept.transpose() + gain * random * gain.transpose();
}

void CorrectedPoseFilter::change_spread(PoseSource source, const Eigen::Matrix3d& spread) {
  MapError& error = error_of(source);
  const bool was_known = std::exchange(error.known, true);
  error.spread = spread;
  if (!was_known) {
    error.scaled_to = spread;
    return reset_error(source);
  }
  const Eigen::Array3d ratios = spread.diagonal().array() / error.scaled_to.diagonal().array();
  if (ratios.maxCoeff() < kOtherSpread && ratios.minCoeff() > 1.0 / kOtherSpread) return;
  const Eigen::Matrix3d root_before = std::exchange(error.scaled_to, spread).llt().matrixL();
  const Eigen::Matrix3d root = spread.llt().matrixL();
  const Eigen::Matrix3d scaling =
      root_before.transpose().triangularView<Eigen::Upper>().solve(root.transpose()).transpose();
  error.mean = scaling * error.mean;
  const Eigen::Index row = row_of(source);
  covariance_.middleRows<3>(row) = scaling * covariance_.middleRows<3>(row).eval();
  covariance_.middleCols<3>(row) = covariance_.middleCols<3>(row).eval() * scaling.transpose();
}

void CorrectedPoseFilter::reset_error(PoseSource source) {
  const Eigen::Index row = row_of(source);
  error_of(source).mean.setZero();
  covariance_.middleRows<3>(row).setZero();
  covariance_.middleCols<3>(row).setZero();
  covariance_.block<3, 3>(row, row) = error_of(source).spread;
}

bool CorrectedPoseFilter::other_speaks_against(PoseSource source, common::Nanoseconds stamp,
                                               const UncertainPose& candidate) const {
  for (const auto& [other, support] : supports_) {
    if (other == source || std::abs(common::to_seconds(stamp - support.stamp)) > options_.support_memory) continue;
    const UncertainPose now = moved(support.pose, support.T_odom_base.inverse() * T_odom_base_, 0.0, options_.drift);
    if (squared_distance(candidate, now) > options_.gate) return true;
  }
  return false;
}

}  // namespace slamfuse::fusion
