// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "visual_slam/motion_model.hpp"

namespace slamfuse::visual_slam {

/// What the innovations of an image say about slip.
struct SlipEvidence {
  double evidence = 0.0;  ///< see slip_evidence()
  double share = 0.0;     ///< most likely slip in standard deviations, of the way or the turn, whichever shows more;
                          ///< below 0 when the robot moves less than the odometry says
};

/// Twice the logarithm of how much likelier the innovations are if the wheels have begun to slip (or stopped to) since
/// the last image. Then their covariance is S + D D^T instead of S; `by_slip`, D, is how they change with one standard
/// deviation of slip. The densities are compared on the measurements that agree under the wider one by the chi-square
/// `gate`; 0 when these are too few to tell. Not in the seeds: an odometry that slips violates the white noise of seed
/// 001 section 4.1, and a filter that takes it for noise drags robot and map along.
SlipEvidence slip_evidence(const Eigen::VectorXd& innovations, const Eigen::MatrixXd& covariance,
                           const Eigen::Matrix<double, Eigen::Dynamic, 2>& by_slip, double gate);

/// Says from the evidence of the images when the wheels begin to slip and when they grip again.
///
/// One image seldom tells (20 % of the way between two images is a pixel or two), so the evidence is summed up, never
/// below 0 (Page's CUSUM test). Wheels that slip turn too much, never too little, and gripping ones make up for
/// nothing: slip begins with a robot that moves less than its odometry says, and ends with one that moves more. A slip
/// lasts 10 s at the most; within 10 s after it no other is believed: what does not agree with the odometry then is not
/// explained by slip, but it is a reason for doubt.
class SlipWatch {
 public:
  enum class Verdict { kNothing, kSlip, kGrip };

  /// The robot has moved by `way` [m] in the map; `slip` is what slip would have done to this step.
  void move(const Slip& slip, const Eigen::Vector2d& way, double seconds);
  /// What slip would have done since the last image; empty when nothing moved.
  const std::optional<Slip>& since_image() const { return since_image_; }
  /// Takes the evidence of an image.
  Verdict judge(const SlipEvidence& image);
  /// The image has been dealt with.
  void next_image() { since_image_.reset(); }
  /// Whether the odometry is not to be relied on: slip goes on, or something that slip does not explain.
  bool doubtful() const;

 private:
  std::optional<Slip> since_image_;
  double suspicion_ = 0.0;
  bool slipping_ = false;
  std::optional<double> changed_;  // [s] since the last verdict
};

}  // namespace slamfuse::visual_slam
