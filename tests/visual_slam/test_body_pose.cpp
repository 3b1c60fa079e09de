// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/body_pose.hpp"

#include <gtest/gtest.h>

namespace slamfuse::visual_slam {
namespace {

TEST(BodyPose, APlanarPoseStaysInThePlane) {
  const BodyPose pose = common::Pose2{1.0, 2.0, 0.5};

  EXPECT_EQ(pose.position, Eigen::Vector3d(1.0, 2.0, 0.0));
  EXPECT_EQ(pose.rotation.col(2), Eigen::Vector3d::UnitZ());
  EXPECT_LT((pose.rotation - BodyPose(common::to_pose3({1.0, 2.0, 0.5})).rotation).norm(), 1e-15);
}

TEST(BodyPose, APlanarTwistMovesAlongItsArc) {
  const Eigen::Vector3d twist(0.5, -0.1, 0.8);

  const BodyPose moved = displacement(BodyTwist(twist), 0.2);

  const BodyPose arc = common::exp_se2(0.2 * twist);
  EXPECT_EQ(moved.position, arc.position);
  EXPECT_EQ(moved.rotation, arc.rotation);
}

TEST(BodyPose, ATwistInSpaceIsExactToSecondOrder) {
  const BodyTwist twist({0.5, -0.1, 0.2}, {0.3, -0.4, 0.8});
  BodyPose small_steps;
  constexpr int kSteps = 2000;
  for (int i = 0; i < kSteps; ++i) {
    small_steps.position += small_steps.rotation * twist.linear * (0.1 / kSteps);
    small_steps.rotation = small_steps.rotation * rotation_exp(twist.angular * (0.1 / kSteps)).toRotationMatrix();
  }

  const BodyPose moved = displacement(twist, 0.1);

  EXPECT_LT((moved.position - small_steps.position).norm(), 5e-5);
  EXPECT_LT((moved.rotation - small_steps.rotation).norm(), 1e-9);
}

TEST(BodyPose, TheLogarithmUndoesTheExponential) {
  for (const Eigen::Vector3d& turn :
       {Eigen::Vector3d(0.4, -1.0, 2.0), Eigen::Vector3d(1e-7, 0.0, -2e-7), Eigen::Vector3d(0.0, 0.0, 0.0)}) {
    EXPECT_LT((rotation_log(rotation_exp(turn)) - turn).norm(), 1e-12);
    Eigen::Quaterniond other_sign = rotation_exp(turn);
    other_sign.coeffs() *= -1.0;
    EXPECT_LT((rotation_log(other_sign) - turn).norm(), 1e-12);
  }
}

TEST(BodyPose, TheLeftJacobianMatchesFiniteDifferences) {
  for (const Eigen::Vector3d& turn : {Eigen::Vector3d(0.4, -0.3, 1.0), Eigen::Vector3d(1e-5, 0.0, -2e-5)}) {
    const Eigen::Vector3d step(1e-6, -2e-6, 3e-6);
    const Eigen::Vector3d left = rotation_log(rotation_exp(turn + step) * rotation_exp(turn).conjugate());
    EXPECT_LT((left - rotation_left_jacobian(turn) * step).norm(), 1e-11);
  }
}

}  // namespace
}  // namespace slamfuse::visual_slam
