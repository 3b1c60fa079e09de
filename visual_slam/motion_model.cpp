// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/motion_model.hpp"

#include <cmath>
#include <numbers>

#include "common/angle.hpp"
#include "visual_slam/constant_velocity.hpp"
#include "visual_slam/free_camera.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr double kSmallTurn = 1e-4;  // [rad] below which series replace quotients

double square(double value) { return value * value; }

Eigen::Matrix3d calibration_covariance(const MotionOptions& motion) {
  if (!motion.calibrate) return Eigen::Matrix3d::Zero();
  return Eigen::Vector3d(square(motion.distance_scale_sigma), square(motion.turn_scale_sigma),
                         square(common::to_radians(motion.turn_per_distance_sigma)))
      .asDiagonal();
}

}  // namespace

Eigen::Matrix3d exp_se2_jacobian(const Eigen::Vector3d& twist) {
  const double w = twist.z();
  const bool small = std::abs(w) < kSmallTurn;
  const double s = small ? 1.0 - w * w / 6.0 : std::sin(w) / w;
  const double c = small ? w / 2.0 : (1.0 - std::cos(w)) / w;
  const double ds = small ? -w / 3.0 : (std::cos(w) - s) / w;
  const double dc = small ? 0.5 - w * w / 8.0 : (std::sin(w) - c) / w;
  Eigen::Matrix3d jacobian;
  jacobian << s, -c, ds * twist.x() - dc * twist.y(),  //
      c, s, dc * twist.x() + ds * twist.y(),           //
      0.0, 0.0, 1.0;
  return jacobian;
}

CalibratedIncrement calibrate_increment(const common::Pose2& measured, const OdometryCalibration& calibration,
                                        const MotionOptions& options) {
  const Eigen::Vector3d raw = common::log_se2(measured);
  const Eigen::Vector3d twist((1.0 + calibration[0]) * raw.x(), (1.0 + calibration[0]) * raw.y(),
                              (1.0 + calibration[1]) * raw.z() + calibration[2] * raw.x());
  const Eigen::Matrix3d by_twist = exp_se2_jacobian(twist);
  Eigen::Matrix3d twist_by_calibration = Eigen::Matrix3d::Zero();
  twist_by_calibration(0, 0) = raw.x();
  twist_by_calibration(1, 0) = raw.y();
  twist_by_calibration(2, 1) = raw.z();
  twist_by_calibration(2, 2) = raw.x();

  const double distance = std::hypot(raw.x(), raw.y());
  const double turns = std::abs(raw.z()) / (2.0 * std::numbers::pi);
  const Eigen::Vector3d variances(square(options.distance_noise) * distance, square(options.lateral_noise) * distance,
                                  square(common::to_radians(options.turn_noise_per_distance)) * distance +
                                      square(common::to_radians(options.turn_noise_per_turn)) * turns);
  return {.increment = common::exp_se2(twist),
          .wrt_calibration = by_twist * twist_by_calibration,
          .noise = by_twist * variances.asDiagonal() * by_twist.transpose()};
}

void predict_pose(State& state, BlockId robot, BlockId calibration, const common::Pose2& measured,
                  const MotionOptions& options) {
  const common::Pose2 pose{state.mean(robot)[0], state.mean(robot)[1], state.mean(robot)[2]};
  const CalibratedIncrement step = calibrate_increment(measured, state.mean(calibration), options);
  const common::ComposeJacobians compose = common::compose_jacobians(pose, step.increment);
  const JacobianPart<Eigen::Dynamic> parts[] = {{robot, compose.wrt_a},
                                                {calibration, compose.wrt_b * step.wrt_calibration}};
  state.transform(robot, (pose * step.increment).vector(), BlockKind::kPose, parts,
                  compose.wrt_b * step.noise * compose.wrt_b.transpose());
}

BlockId MotionModel::append_robot(State& state) const {
  return state.append(Eigen::Vector3d::Zero(), BlockKind::kPose, {},
                      square(kFirstPoseSigma) * Eigen::Matrix3d::Identity());
}

BlockId OdometryMotion::append_parameters(State& state) const {
  return state.append(Eigen::Vector3d::Zero(), BlockKind::kCalibration, {}, calibration_covariance(options_));
}

bool OdometryMotion::predict(State& state, BlockId robot, BlockId parameters, const MotionStep& step) const {
  predict_pose(state, robot, parameters, step.odometry, options_);
  return step.odometry.vector() != Eigen::Vector3d::Zero();
}

std::optional<Slip> OdometryMotion::slip(const State& state, BlockId robot, BlockId parameters,
                                         const MotionStep& step) const {
  if (options_.slip <= 0.0) return std::nullopt;
  const common::Pose2 pose{state.mean(robot)[0], state.mean(robot)[1], state.mean(robot)[2]};
  const CalibratedIncrement calibrated = calibrate_increment(step.odometry, state.mean(parameters), options_);
  Slip slip;
  slip.pose = options_.slip * common::compose_jacobians(pose, calibrated.increment).wrt_b *
              calibrated.wrt_calibration.leftCols<2>();
  slip.parameters = options_.slip * Eigen::Matrix<double, 3, 2>::Identity();
  return slip;
}

double OdometryMotion::improbability(const State& state, BlockId parameters) const {
  const Eigen::Vector3d variances = calibration_covariance(options_).diagonal();
  const Eigen::Vector3d numbers = state.mean(parameters);
  return (variances.array() > 0.0).select(numbers.array().square() / variances.array(), 0.0).sum();
}

MotionOptions for_cameras(MotionOptions options, std::size_t cameras) {
  if (cameras > 1) options.bearing_margin = options.bearing_margin_of_several;
  return options;
}

std::shared_ptr<const MotionModel> make_motion_model(const MotionOptions& options) {
  if (options.model == MotionModelKind::kConstantVelocity) {
    return std::make_shared<ConstantVelocity>(options.constant_velocity);
  }
  if (options.model == MotionModelKind::kFreeCamera) return std::make_shared<FreeCamera>(options.free_camera);
  return std::make_shared<OdometryMotion>(options);
}

}  // namespace slamfuse::visual_slam
