// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/slip_admission.hpp"

#include <gtest/gtest.h>

namespace slamfuse::visual_slam {
namespace {

/// A robot at (1, 0) that has driven 0.1 m along x since the last image; with its odometry's three numbers.
struct Driven {
  State state;
  BlockId robot =
      state.append(Eigen::Vector3d(1.0, 0.0, 0.0), BlockKind::kPose, {}, 1e-6 * Eigen::Matrix3d::Identity());
  BlockId parameters =
      state.append(Eigen::Vector3d(0.01, 0.02, 0.0), BlockKind::kCalibration, {}, 1e-4 * Eigen::Matrix3d::Identity());
  Slip slip;

  Driven() {
    slip.pose << 0.02, 0.0, 0.0, 0.0, 0.0, 0.0;
    slip.parameters = Eigen::MatrixXd::Zero(3, 2);
    slip.parameters(0, 0) = slip.parameters(1, 1) = 0.2;
  }
};

TEST(SlipAdmission, MakesScaleAndTheLastWayAsUncertainTogetherAsSlipDoes) {
  Driven driven;
  SlipAdmission().begin(driven.state, driven.robot, driven.parameters, driven.slip);

  EXPECT_EQ(driven.state.size(), 6);
  EXPECT_NEAR(driven.state.covariance(driven.parameters, driven.parameters)(0, 0), 0.2 * 0.2 + 1e-4, 1e-12);
  EXPECT_NEAR(driven.state.covariance(driven.robot, driven.robot)(0, 0), 0.02 * 0.02 + 1e-6, 1e-12);
  EXPECT_NEAR(driven.state.covariance(driven.robot, driven.parameters)(0, 0), 0.2 * 0.02, 1e-12);
  EXPECT_EQ(driven.state.mean(driven.robot).x(), 1.0);
}

TEST(SlipAdmission, GivesBackWhatTheOdometryWasBeforeAndMovesTheRobotAccordingly) {
  Driven driven;
  SlipAdmission admission;
  admission.begin(driven.state, driven.robot, driven.parameters, driven.slip);
  driven.state.mean(driven.parameters)[0] = -0.19;  // the camera says the wheels slip by 20 %

  admission.end(driven.state, driven.robot, driven.parameters, driven.slip);

  EXPECT_NEAR(driven.state.mean(driven.parameters)[0], 0.01, 1e-12);
  EXPECT_NEAR(driven.state.covariance(driven.parameters, driven.parameters)(0, 0), 1e-4, 1e-12);
  EXPECT_NEAR(driven.state.mean(driven.robot).x(), 1.02, 1e-9);  // 0.1 m that were too short by 20 %
}

}  // namespace
}  // namespace slamfuse::visual_slam
