// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/motion_model.hpp"

#include <gtest/gtest.h>

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;

constexpr double kStep = 1e-6;

TEST(MotionModel, JacobianOfTheExponentialMatchesFiniteDifferences) {
  for (const double turn : {0.0, 1e-5, 0.2, -1.3}) {
    const Eigen::Vector3d twist(0.4, -0.1, turn);

    const Eigen::Matrix3d jacobian = exp_se2_jacobian(twist);

    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      const Eigen::Vector3d difference =
          (common::exp_se2(twist + step).vector() - common::exp_se2(twist - step).vector()) / (2.0 * kStep);
      EXPECT_LT((jacobian.col(i) - difference).norm(), 1e-8) << turn;
    }
  }
}

TEST(MotionModel, SystematicErrorsAreTakenOut) {
  const Pose2 measured = common::exp_se2({0.5, 0.0, 0.2});

  const CalibratedIncrement step = calibrate_increment(measured, {0.02, -0.03, 0.01}, {});

  const Eigen::Vector3d twist = common::log_se2(step.increment);
  EXPECT_NEAR(twist.x(), 0.51, 1e-12);
  EXPECT_NEAR(twist.z(), 0.2 * 0.97 + 0.5 * 0.01, 1e-12);
}

TEST(MotionModel, DerivativeByTheCalibrationMatchesFiniteDifferences) {
  const Pose2 measured = common::exp_se2({0.5, 0.02, 0.2});
  const Eigen::Vector3d calibration(0.02, -0.03, 0.01);

  const Eigen::Matrix3d jacobian = calibrate_increment(measured, calibration, {}).wrt_calibration;

  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
    const Eigen::Vector3d difference = (calibrate_increment(measured, calibration + step, {}).increment.vector() -
                                        calibrate_increment(measured, calibration - step, {}).increment.vector()) /
                                       (2.0 * kStep);
    EXPECT_LT((jacobian.col(i) - difference).norm(), 1e-8);
  }
}

TEST(MotionModel, StandingStillAddsNoNoiseAndDrivingAddsItByTheRootOfTheWay) {
  const MotionOptions options;

  const Eigen::Matrix3d still = calibrate_increment({}, Eigen::Vector3d::Zero(), options).noise;
  const Eigen::Matrix3d metre = calibrate_increment({1.0, 0.0, 0.0}, Eigen::Vector3d::Zero(), options).noise;

  EXPECT_EQ(still.norm(), 0.0);
  EXPECT_NEAR(std::sqrt(metre(0, 0)), options.distance_noise, 1e-12);
}

TEST(MotionModel, PredictionMovesOnlyTheRobotAndGrowsItsCovariance) {
  State state;
  const BlockId robot =
      state.append(Eigen::Vector3d(1.0, 2.0, 0.5), BlockKind::kPose, {}, 1e-4 * Eigen::Matrix3d::Identity());
  const BlockId calibration =
      state.append(Eigen::Vector3d::Zero(), BlockKind::kCalibration, {}, 1e-4 * Eigen::Matrix3d::Identity());
  const BlockId landmark =
      state.append(Eigen::Vector3d(3.0, 1.0, 0.5), BlockKind::kPoint, {}, 1e-2 * Eigen::Matrix3d::Identity());

  predict_pose(state, robot, calibration, {0.5, 0.0, 0.1}, {});

  EXPECT_NEAR(state.mean(robot)[0], 1.0 + 0.5 * std::cos(0.5), 1e-3);
  EXPECT_EQ(state.mean(landmark)[0], 3.0);
  EXPECT_GT(state.covariance(robot, robot)(0, 0), 1e-4);
  EXPECT_GT(state.covariance(robot, calibration).norm(), 0.0);
  EXPECT_LT((state.covariance() - state.covariance().transpose()).norm(), 1e-15);
}

TEST(MotionModel, SeveralCamerasHaveTheirOwnMarginOfBearings) {
  MotionOptions options;
  options.bearing_margin = 1.5;
  options.bearing_margin_of_several = 1.1;
  EXPECT_EQ(OdometryMotion(for_cameras(options, 1)).bearing_margin(), 1.5);
  EXPECT_EQ(OdometryMotion(for_cameras(options, 2)).bearing_margin(), 1.1);
}

}  // namespace
}  // namespace slamfuse::visual_slam
