// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/bend_tracker.hpp"

#include <cmath>

#include <Eigen/Cholesky>

#include "common/angle.hpp"

namespace slamfuse::fusion {

void BendTracker::restart(const Eigen::Matrix3d& spread) {
  bend_.setZero();
  covariance_ = spread_ = spread;
}

void BendTracker::realign(const Eigen::Vector3d& step, const Eigen::Matrix3d& spread) {
  bend_ -= step;
  bend_.z() = common::normalize_angle(bend_.z());
  spread_ = spread;
}

void BendTracker::move(double distance) {
  const double kept = std::exp(-distance / options_.length);
  bend_ *= kept;
  covariance_ = kept * kept * covariance_ + (1.0 - kept * kept) * spread_;
}

bool BendTracker::update(const Eigen::Vector3d& residual, const Eigen::Matrix3d& noise, double gate) {
  Eigen::Vector3d innovation = residual - bend_;
  innovation.z() = common::normalize_angle(innovation.z());
  const auto distance = [&] { return innovation.dot((covariance_ + noise).ldlt().solve(innovation)); };
  if (distance() > gate) {
    const Eigen::Matrix3d before = covariance_;
    covariance_ = covariance_ + spread_;
    if (distance() > gate) {
      covariance_ = before;
      return false;
    }
  }
  // Joseph's form keeps the covariance positive definite.
  const Eigen::Matrix3d gain = (covariance_ + noise).ldlt().solve(covariance_).transpose();
  const Eigen::Matrix3d kept = Eigen::Matrix3d::Identity() - gain;
  bend_ += gain * innovation;
  bend_.z() = common::normalize_angle(bend_.z());
  covariance_ = kept * covariance_ * kept.transpose() + gain * noise * gain.transpose();
  return true;
}

UncertainPose BendTracker::correct(const UncertainPose& aligned) const {
  return {
      {aligned.pose.x + bend_.x(), aligned.pose.y + bend_.y(), common::normalize_angle(aligned.pose.theta + bend_.z())},
      aligned.covariance + covariance_};
}

}  // namespace slamfuse::fusion
