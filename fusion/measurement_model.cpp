// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/measurement_model.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace slamfuse::fusion {
namespace {

/// Ten kilometres: who knows less than this of his place knows nothing, and larger numbers only lose digits.
constexpr double kLargestVariance = 1e8;

/// By how much the poses to come are further off than those that were seen [standard deviations] where a scale was
/// fitted: part of the bend is in the scale then, which grows wrong away from the pairs. With 3 a visual half without
/// a scale of its own still moves the pose of a healthy laser, beyond 5 nothing changes.
constexpr double kScaledMap = 5.0;

Eigen::Matrix3d variances(double position_sigma, double heading_sigma) {
  const double position = position_sigma * position_sigma;
  return Eigen::Vector3d(position, position, heading_sigma * heading_sigma).asDiagonal();
}

Eigen::Matrix3d moved_covariance(const Eigen::Matrix3d& covariance, const Eigen::Matrix2d& linear) {
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity();
  jacobian.topLeftCorner<2, 2>() = linear;
  return jacobian * covariance * jacobian.transpose();
}

}  // namespace

std::optional<std::string> flaw_of(const common::PoseEstimate& estimate) {
  if (estimate.source != common::PoseSource::kLaser && estimate.source != common::PoseSource::kVisual) {
    return fmt::format("source {} is neither laser nor visual", common::to_string(estimate.source));
  }
  if (!estimate.pose.is_finite()) {
    return fmt::format("the pose ({}, {}, {}) is not finite", estimate.pose.x, estimate.pose.y, estimate.pose.theta);
  }
  if (!estimate.covariance.allFinite()) return "the covariance is not finite";
  const Eigen::Vector3d variances = estimate.covariance.diagonal();
  if (variances.minCoeff() < 0.0 || variances.maxCoeff() > kLargestVariance) {
    return fmt::format("the covariance has the variances {}, {} and {}; allowed are 0 to {}", variances.x(),
                       variances.y(), variances.z(), kLargestVariance);
  }
  // A tiny floor lets covariances pass that are singular, e.g. all zero.
  constexpr double kTiny = 1e-12;
  const Eigen::Matrix3d symmetric = 0.5 * (estimate.covariance + estimate.covariance.transpose());
  const Eigen::LLT<Eigen::Matrix3d> factor(symmetric + kTiny * (1.0 + symmetric.norm()) * Eigen::Matrix3d::Identity());
  if (factor.info() != Eigen::Success) return "the covariance is not positive semidefinite";
  return std::nullopt;
}

UncertainPose measurement_of(const common::PoseEstimate& estimate, const MeasurementOptions& options) {
  Eigen::Matrix3d covariance = 0.5 * (estimate.covariance + estimate.covariance.transpose());
  covariance += variances(options.smallest_position_sigma, options.smallest_heading_sigma);
  if (estimate.state == common::TrackingState::kUncertain) {
    covariance *= options.uncertain_inflation * options.uncertain_inflation;
  }
  return {estimate.pose, covariance};
}

UncertainPose aligned_pose(const UncertainPose& visual, const Alignment& alignment) {
  return {alignment.to_laser(visual.pose), moved_covariance(visual.covariance, alignment.map.linear)};
}

Eigen::Matrix3d alignment_error(const Alignment& alignment, const Eigen::Vector2d& visual) {
  // Half of a squared distance for each axis.
  const double rmse = std::max(alignment.heldout_rmse, alignment.forward_rmse);
  Eigen::Matrix3d error = variances(rmse / std::sqrt(2.0), alignment.heading_rmse);
  error.topLeftCorner<2, 2>() += alignment.position_covariance(visual);
  if (alignment.method != AlignmentMethod::kRigid) error.topLeftCorner<2, 2>() *= kScaledMap * kScaledMap;
  return error;
}

UncertainPose visual_pose(const UncertainPose& aligned, const Alignment& alignment) {
  return {alignment.to_visual(aligned.pose), moved_covariance(aligned.covariance, alignment.map.linear.inverse())};
}

}  // namespace slamfuse::fusion
