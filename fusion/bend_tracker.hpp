// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "common/options.hpp"
#include "fusion/uncertain_pose.hpp"

namespace slamfuse::fusion {

/// How fast the two maps may come to differ along the drive.
struct BendOptions {
  double length = 5.0;

  void describe(common::OptionVisitor& visit) {
    visit.real("length", length, {0.1, 1000.0}, "m",
               "After this distance the difference of the two maps has changed by most of what it can.");
  }
};

/// Follows how far the aligned visual map is off the laser map *here*. One affine map meets a visual map that bends
/// (drift of scale and heading) on average only; what is left of it at one place, r = laser minus aligned visual in
/// (x, y, theta), hardly changes over the next metre. It is taken as a Gauss-Markov process over the distance driven,
///
///     r(s + d) = e^(-d / l) r(s) + w,   var w = (1 - e^(-2 d / l)) S,
///
/// S being what pairs that the alignment had not seen were off by, and is estimated from the pairs as they come with
/// the usual Kalman update. While both halves speak the visual pose is thereby as good as the laser's map allows, and
/// when the laser falls silent it carries on without a step and returns to what the alignment alone says.
class BendTracker {
 public:
  explicit BendTracker(const BendOptions& options) : options_(options) {}

  /// Forgets what was estimated; from now on r is 0 with covariance `spread`, S above.
  void restart(const Eigen::Matrix3d& spread);
  /// The alignment was replaced by one that moves the place here by `step` (new minus old aligned pose): the corrected
  /// pose stays where it was. `spread` is S of the new one.
  void realign(const Eigen::Vector3d& step, const Eigen::Matrix3d& spread);
  /// The robot has driven on by `distance` [m].
  void move(double distance);
  /// Both halves told of one moment: `residual` is laser minus aligned visual, with the covariance of what both are off
  /// by at random. A residual beyond `gate` (squared Mahalanobis distance) means that one of the maps made a step, e.g.
  /// closed a loop: what was estimated before does not count then. One that is beyond what the alignment can be off by
  /// is not used, and false returned.
  bool update(const Eigen::Vector3d& residual, const Eigen::Matrix3d& noise, double gate);

  const Eigen::Vector3d& bend() const { return bend_; }              ///< r
  const Eigen::Matrix3d& covariance() const { return covariance_; }  ///< of r
  /// An aligned visual pose moved by r; the covariance of r is added to its own.
  UncertainPose correct(const UncertainPose& aligned) const;

 private:
  BendOptions options_;
  Eigen::Vector3d bend_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d spread_ = Eigen::Matrix3d::Identity();
};

}  // namespace slamfuse::fusion
