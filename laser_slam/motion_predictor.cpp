// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/motion_predictor.hpp"

#include "laser_slam/motion_model.hpp"

namespace slamfuse::laser_slam {
namespace {

/// Scans closer or farther apart than this say nothing about the speed [s].
constexpr double kShortestStep = 0.02;
constexpr double kLongestStep = 1.0;

}  // namespace

void MotionPredictor::start(common::Nanoseconds stamp) {
  last_stamp_ = stamp;
  last_odometry_ = odometry_.pose_at(stamp);
  last_half_ = begun_half_;
  twist_.setZero();
  stalled_ = 0.0;
}

MotionPrediction MotionPredictor::predict(common::Nanoseconds stamp) const {
  MotionPrediction prediction;
  prediction.seconds = common::to_seconds(stamp - last_stamp_);
  prediction.at_most_seconds = stalled_ + prediction.seconds;
  if (const auto odometry = odometry_.pose_at(stamp); odometry && last_odometry_) {
    prediction.increment = last_odometry_->inverse() * *odometry;
    prediction.from_odometry = true;
    prediction.suspicious = is_jump(prediction.increment, prediction.at_most_seconds, options_);
    return prediction;
  }
  prediction.increment = at_last_speed(prediction.seconds);
  return prediction;
}

common::Pose2 MotionPredictor::at_last_speed(double seconds) const {
  if (seconds <= 0.0 || seconds > kLongestStep) return {};
  return last_half_ * common::exp_se2(twist_ * seconds) * begun_half_.inverse();
}

void MotionPredictor::finish(common::Nanoseconds stamp, const MotionPrediction& prediction,
                             const common::Pose2& matched) {
  last_stamp_ = stamp;
  last_odometry_ = odometry_.pose_at(stamp);
  if (prediction.seconds > kShortestStep && prediction.seconds < kLongestStep) {
    twist_ = common::log_se2(last_half_.inverse() * matched * begun_half_) / prediction.seconds;
  } else if (prediction.seconds >= kLongestStep) {
    twist_.setZero();
  }
  stalled_ = prediction.seconds >= kLongestStep ? prediction.seconds : 0.0;
  last_half_ = begun_half_;
}

Eigen::Vector3d MotionPredictor::begin_sweep(common::Nanoseconds stamp, common::Nanoseconds duration) {
  const Eigen::Vector3d twist = sweep_twist(stamp, duration);
  begun_half_ = common::exp_se2(twist * (0.5 * common::to_seconds(duration)));
  return twist;
}

Eigen::Vector3d MotionPredictor::sweep_twist(common::Nanoseconds stamp, common::Nanoseconds duration) const {
  if (duration <= 0) return Eigen::Vector3d::Zero();
  const auto first = odometry_.pose_at(stamp);
  const auto last = odometry_.pose_at(stamp + duration);
  if (!first || !last) return twist_;
  const common::Pose2 motion = first->inverse() * *last;
  const double seconds = common::to_seconds(duration);
  return is_jump(motion, seconds, options_) ? twist_ : Eigen::Vector3d(common::log_se2(motion) / seconds);
}

}  // namespace slamfuse::laser_slam
