// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/confidence.hpp"

#include <cmath>

#include <Eigen/Cholesky>

#include "common/angle.hpp"
#include "common/trajectory_evaluation.hpp"

namespace slamfuse::visual_slam::testing {
namespace {

constexpr double kChiSquare3 = 16.27;    // 0.999
constexpr double kFramePosition = 0.02;  // [m], how well the frame is known that the truth was brought to
constexpr double kFrameHeading = 0.01;   // [rad]
constexpr common::Nanoseconds kMaxGap = common::kNanosecondsPerSecond / 10;

}  // namespace

std::vector<JudgedEstimate> judge(const std::vector<common::PoseEstimate>& estimates, const common::Trajectory2& truth,
                                  common::Nanoseconds fit_until) {
  common::Trajectory2 before;
  for (const auto& estimate : estimates) {
    if (estimate.stamp <= fit_until) before.push_back({estimate.stamp, estimate.pose});
  }
  const auto fit = common::evaluate_trajectory(before, truth);
  if (!fit) return {};
  const common::Similarity2 T_map_truth = fit->T_reference_estimate.inverse();
  const Eigen::Vector3d floor(kFramePosition, kFramePosition, kFrameHeading);
  std::vector<JudgedEstimate> judged;
  for (const auto& estimate : estimates) {
    const auto right = common::pose_at(truth, estimate.stamp, kMaxGap);
    if (!right) continue;
    const common::Pose2 there = T_map_truth * *right;
    const Eigen::Vector3d error(estimate.pose.x - there.x, estimate.pose.y - there.y,
                                common::normalize_angle(estimate.pose.theta - there.theta));
    const Eigen::Matrix3d covariance = estimate.covariance + Eigen::Matrix3d(floor.cwiseProduct(floor).asDiagonal());
    judged.push_back({estimate.stamp, estimate.state, error.head<2>().norm(), std::abs(error.z()),
                      error.dot(covariance.llt().solve(error))});
  }
  return judged;
}

bool is_false_confidence(const JudgedEstimate& estimate) {
  return estimate.state == common::TrackingState::kTracking &&
         (estimate.position > kMaxPosition || estimate.heading > kMaxHeading) && estimate.mahalanobis > kChiSquare3;
}

}  // namespace slamfuse::visual_slam::testing
