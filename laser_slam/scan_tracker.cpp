// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/scan_tracker.hpp"

#include <Eigen/LU>

#include "laser_slam/motion_model.hpp"

namespace slamfuse::laser_slam {
namespace {

constexpr double kEnoughKnown = 0.3;  // share of the beams in mapped space for their agreement to count

}  // namespace

Eigen::Matrix3d ScanTracker::covariance_of(const MotionPrediction& prediction) const {
  if (!prediction.from_odometry) return prediction_covariance(prediction.seconds, motion_);
  Travel travel;
  travel += prediction.increment;
  return odometry_covariance(travel, motion_);
}

TrackedScan ScanTracker::track(const GridMap& map, const std::vector<Eigen::Vector2d>& points,
                               const common::Pose2& last, const MotionPrediction& prediction,
                               const MotionPredictor& predictor, double old_before) const {
  const PosePrior prior{last * prediction.increment,
                        to_parent_frame(covariance_of(prediction), last * prediction.increment).inverse()};
  TrackedScan tracked;
  tracked.match = matcher_.match(map, points, prior.mean, prior, old_before);
  tracked.odometry_doubted = prediction.refused_odometry.has_value();

  const auto enough_known = [&](const ScanFit& fit) {
    return fit.known >= kEnoughKnown * static_cast<double>(points.size());
  };
  if (tracked.match.fit.agreement < matching_.rematch_agreement && enough_known(tracked.match.fit)) {
    const double to_beat = tracked.match.fit.agreement + matching_.rematch_gain;
    std::vector<ScanMatch> others;
    const auto climb_from = [&](const common::Pose2& start) {
      others.push_back(matcher_.match(map, points, start, PosePrior{start, Eigen::Matrix3d::Zero()}, old_before));
    };
    climb_from(last);
    climb_from(last * predictor.at_last_speed(prediction.seconds));
    if (prediction.refused_odometry) climb_from(last * *prediction.refused_odometry);
    others.push_back(matcher_.search(map, points, prior.mean, old_before));
    for (const ScanMatch& other : others) {
      if (!enough_known(other.fit) || other.fit.agreement <= to_beat) continue;
      if (tracked.odometry_doubted && other.fit.agreement <= tracked.match.fit.agreement) continue;
      tracked.match = other;
      tracked.odometry_doubted = true;
    }
  }
  tracked.increment = last.inverse() * tracked.match.pose;
  return tracked;
}

}  // namespace slamfuse::laser_slam
