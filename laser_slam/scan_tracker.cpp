// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/scan_tracker.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "laser_slam/motion_model.hpp"

namespace slamfuse::laser_slam {
namespace {

/// A motion that differs so much [m, rad] from the last speed is checked against it: half the matcher's basin. There
/// are logs in which the odometry counts forward while the robot backs up (fr079).
constexpr double kSurprise = 0.05;
/// A scan of fewer beams must be likelier by as much as one of so many: a few beams meet something in many places.
constexpr double kFewestBeams = 180.0;
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
  const double beams = static_cast<double>(points.size());
  const double enough = kEnoughKnown * beams;
  const bool doubtful = tracked.match.fit.agreement < matching_.rematch_agreement && tracked.match.fit.known >= enough;
  const common::Pose2 coasting = predictor.at_last_speed(prediction.seconds);
  const common::Pose2 disagreement = prediction.increment.inverse() * coasting;
  const bool surprising =
      std::max(std::hypot(disagreement.x, disagreement.y), std::abs(disagreement.theta)) > kSurprise;
  if (prediction.suspicious || doubtful || surprising) {
    // The likelihood decides: it also counts how much of the scan meets the map at all. But it alone would leave the
    // map, where beams cost little, so what is known must agree better too. Odometry too fast to be true that leads out
    // of the map has nothing to speak for it.
    const bool astray = prediction.suspicious && tracked.match.fit.known < enough;
    double to_beat =
        astray ? -HUGE_VAL : tracked.match.fit.log_likelihood + matching_.rematch_gain * std::max(beams, kFewestBeams);
    const auto consider = [&](const ScanMatch& other) {
      if (other.fit.log_likelihood <= to_beat || (astray && other.fit.known < enough)) return;
      if (!astray && other.fit.agreement <= tracked.match.fit.agreement) return;
      const common::Pose2 apart = prior.mean.inverse() * other.pose;
      const bool near =
          std::hypot(apart.x, apart.y) <= matching_.search_distance && std::abs(apart.theta) <= matching_.search_angle;
      if (!near && !prediction.suspicious) return;
      if (is_jump(last.inverse() * other.pose, prediction.at_most_seconds, motion_)) return;
      to_beat = other.fit.log_likelihood;
      tracked.match = other;
      tracked.odometry_doubted = true;
    };
    const bool search = prediction.suspicious || doubtful;
    for (const common::Pose2& begin : {last * coasting, last}) {
      consider(matcher_.match(map, points, begin, PosePrior{begin, Eigen::Matrix3d::Zero()}, old_before));
      if (search) consider(matcher_.search(map, points, begin, old_before));
    }
    if (search) consider(matcher_.search(map, points, prior.mean, old_before));
  }
  tracked.increment = last.inverse() * tracked.match.pose;
  return tracked;
}

}  // namespace slamfuse::laser_slam
