// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/motion_accumulator.hpp"

#include <algorithm>
#include <cmath>

namespace slamfuse::laser_slam {
namespace {

constexpr double kLongestPrediction = 0.2;  // [s] beyond it a match is no less certain

}  // namespace

void MotionAccumulator::clear() { *this = MotionAccumulator(options_); }

void MotionAccumulator::add(const MotionPrediction& prediction, const TrackedScan& tracked) {
  matched_travel_ += tracked.increment;
  matched_ = matched_ * tracked.increment;
  const bool believe = prediction.from_odometry && !tracked.odometry_doubted;
  const common::Pose2 increment = believe ? prediction.increment : tracked.increment;
  believed_ = believed_ * increment;
  predicted_ = predicted_ * prediction.increment;
  predicted_travel_ += prediction.increment;
  doubted_ = doubted_ || tracked.odometry_doubted;
  if (believe) {
    odometry_travel_ += increment;
  } else {
    predicted_covariance_ +=
        prediction_covariance(std::min(std::abs(prediction.seconds), kLongestPrediction), options_);
  }
}

Eigen::Matrix3d MotionAccumulator::covariance() const {
  return odometry_covariance(matched_travel_, options_) + predicted_covariance_;
}

MotionSinceUpdate MotionAccumulator::believed() const {
  return {believed_, odometry_covariance(odometry_travel_, options_) + predicted_covariance_, matched_};
}

std::vector<MotionSinceUpdate> MotionAccumulator::candidates() const {
  std::vector<MotionSinceUpdate> result{believed()};
  if (doubted_) result.push_back({predicted_, odometry_covariance(predicted_travel_, options_), predicted_});
  return result;
}

}  // namespace slamfuse::laser_slam
