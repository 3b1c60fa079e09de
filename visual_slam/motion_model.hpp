// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "visual_slam/body_pose.hpp"
#include "visual_slam/options.hpp"
#include "visual_slam/state.hpp"

namespace slamfuse::visual_slam {

/// Systematic errors of the wheel odometry, three numbers of the state: the true distance is (1 + a) times the measured
/// one, the true turn is (1 + b) times the measured one plus c for each metre driven.
using OdometryCalibration = Eigen::Vector3d;

/// Jacobian of exp_se2 in (x, y, theta) of the result with respect to the twist.
Eigen::Matrix3d exp_se2_jacobian(const Eigen::Vector3d& twist);

/// An odometry increment with the systematic errors taken out, and its derivatives.
struct CalibratedIncrement {
  common::Pose2 increment;
  Eigen::Matrix3d wrt_calibration;
  Eigen::Matrix3d noise;  ///< covariance of (x, y, theta) of the increment
};
CalibratedIncrement calibrate_increment(const common::Pose2& measured, const OdometryCalibration& calibration,
                                        const MotionOptions& options);

/// EKF prediction (seed 001 section 3, step 1): the pose block moves by the odometry increment, its covariance grows by
/// the noise of the increment and by what is not known of the calibration.
void predict_pose(State& state, BlockId robot, BlockId calibration, const common::Pose2& measured,
                  const MotionOptions& options);

/// From one image to the next.
struct MotionStep {
  double seconds = 0.0;
  common::Pose2 odometry;  ///< what the wheel odometry says, for those that use it
  /// Whether the speed is measured from outside, so that it need not be held to; the filter says so to those that use
  /// it (ConstantVelocity).
  bool speed_is_told = false;
};

/// What slipping wheels do, by one standard deviation of slip along the way (first column) and in the turn (second).
struct Slip {
  Eigen::Matrix<double, 3, 2> pose;                     ///< to (x, y, theta) of the robot in the map
  Eigen::Matrix<double, Eigen::Dynamic, 2> parameters;  ///< to the numbers of the motion model
};

/// A number measured of the robot's motion, as a function of the motion model's numbers.
struct MotionNumber {
  double value = 0.0;
  Eigen::RowVectorXd wrt_parameters;
};

/// How the robot moves between images, and with it whether poses are planar or free: past poses are copies of the
/// robot's block. The filter keeps the model's own numbers in the second block of its state.
class MotionModel {
 public:
  virtual ~MotionModel() = default;

  /// Enters the robot's pose at the map's origin, in three numbers unless the model says otherwise.
  virtual BlockId append_robot(State& state) const;
  /// Enters the model's numbers, whose first is the relative error of the map's scale (see State::correct).
  virtual BlockId append_parameters(State& state) const = 0;
  /// Moves the robot's block. Returns whether the pose may have changed.
  virtual bool predict(State& state, BlockId robot, BlockId parameters, const MotionStep& step) const = 0;
  /// What it means when the wheels begin to slip (or stop to) with this step; empty when there are no wheels or they
  /// never slip. To be asked before predict().
  virtual std::optional<Slip> slip(const State&, BlockId, BlockId, const MotionStep&) const { return std::nullopt; }
  /// How far the model's numbers are from what its options promise, as a squared number of standard deviations of so
  /// many degrees of freedom as there are numbers.
  virtual double improbability(const State&, BlockId) const { return 0.0; }
  /// Whether the model knows metres. Otherwise the landmarks must teach the robot how fast it moves.
  virtual bool is_metric() const = 0;
  /// How many times as noisy as they are the bearings of one camera are to be taken, to make room for what the
  /// linearisation gets wrong: with it the covariances are right (README, consistency).
  virtual double bearing_margin() const { return 1.0; }
  /// How many units of the map a metre is.
  virtual double lever_scale(const State& state, BlockId parameters) const = 0;
  /// Which of the numbers is the logarithm of lever_scale; empty when it is no number but known.
  virtual std::optional<int> lever_scale_index() const = 0;
  /// How base_link moves (units of the map a second, rad/s); empty when the numbers do not say.
  virtual std::optional<BodyTwist> twist(const State& state, BlockId parameters) const = 0;
  /// The mean speed forward [m/s] of the step that was predicted last; empty when the model does not say or knows it
  /// better.
  virtual std::optional<MotionNumber> metric_speed(const State&, BlockId) const { return std::nullopt; }
};

/// Standard deviation [m], [rad] of the first pose. The map frame is the first pose, so it is known.
inline constexpr double kFirstPoseSigma = 1e-4;

/// Planar motion measured by wheel odometry; its numbers are the OdometryCalibration.
class OdometryMotion : public MotionModel {
 public:
  explicit OdometryMotion(const MotionOptions& options) : options_(options) {}

  BlockId append_parameters(State& state) const override;
  bool predict(State& state, BlockId robot, BlockId parameters, const MotionStep& step) const override;
  std::optional<Slip> slip(const State& state, BlockId robot, BlockId parameters,
                           const MotionStep& step) const override;
  double improbability(const State& state, BlockId parameters) const override;
  bool is_metric() const override { return true; }
  double bearing_margin() const override { return options_.bearing_margin; }
  double lever_scale(const State&, BlockId) const override { return 1.0; }
  std::optional<int> lever_scale_index() const override { return std::nullopt; }
  std::optional<BodyTwist> twist(const State&, BlockId) const override { return std::nullopt; }

 private:
  MotionOptions options_;
};

/// The options for so many cameras: several have their own `bearing_margin`.
MotionOptions for_cameras(MotionOptions options, std::size_t cameras);

/// The model the options name.
std::shared_ptr<const MotionModel> make_motion_model(const MotionOptions& options);

}  // namespace slamfuse::visual_slam
