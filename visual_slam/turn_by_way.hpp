// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "visual_slam/camera.hpp"

namespace slamfuse::visual_slam {

/// A feature that was followed from one picture of a camera to another.
struct FollowedFeature {
  Eigen::Vector2d before = Eigen::Vector2d::Zero();  ///< [px]
  Eigen::Vector2d now = Eigen::Vector2d::Zero();     ///< [px]
};

/// From one picture of a camera to the next.
struct PictureStep {
  double seconds = 0.0;
  double last_turn_rate = 0.0;  ///< of base_link while the first picture was exposed, row by row [rad/s]
};

/// How far base_link has turned in a step [rad], to the left, for each way it may have driven meanwhile [m].
///
/// Features of unknown depth tell the turn if the way is known: wheels do not go sideways, so way and turn say along
/// which line of the picture each feature moves. With the way unknown this is the one-point method of Scaramuzza 2011;
/// here the camera's place on the robot is known in metres too, so that the way matters. The turn for a way is that at
/// which most features lie on their lines. Not in the seeds.
class TurnByWay {
 public:
  /// The same turn for every way.
  explicit TurnByWay(double turn) : turns_{turn, turn} {}
  /// By features followed, for ways from `least` to `most`. With fewer than eight of them, `otherwise` [rad].
  TurnByWay(const Camera& camera, std::span<const FollowedFeature> features, const PictureStep& step, double least,
            double most, double otherwise);

  /// The turn for a way; beyond those asked for it is that of the last.
  double operator()(double way) const;
  /// How well the features lie on their lines if the robot has driven about this way, as a logarithm against the way at
  /// which they do best: that of the better of the two ways next to it, since a top may be narrower than their
  /// distance. 0 when the turn does not depend on the way. Only turns tell one way from the other.
  double log_likelihood(double way) const;

 private:
  /// A way among those asked for: between the one of number i and the next.
  struct Place {
    std::size_t i = 0;
    double part = 0.0;
  };
  Place place(double way) const;

  double least_ = 0.0;
  double step_ = 1.0;
  std::vector<double> turns_;  // at least_, least_ + step_ and so on
  std::vector<double> likelihoods_;
};

}  // namespace slamfuse::visual_slam
