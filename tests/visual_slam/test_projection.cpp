// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/projection.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;
using testing::make_camera;

constexpr double kStep = 1e-6;

common::Pose2 to_pose(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Central differences of a function of three numbers.
template <int Rows>
Eigen::Matrix<double, Rows, 3> differentiate(
    const std::function<Eigen::Matrix<double, Rows, 1>(const Eigen::Vector3d&)>& function, const Eigen::Vector3d& at) {
  Eigen::Matrix<double, Rows, 3> jacobian;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
    jacobian.col(i) = (function(at + step) - function(at - step)) / (2.0 * kStep);
  }
  return jacobian;
}

/// The part of a derivative by a pose that belongs to (x, y, theta).
template <int Rows>
Eigen::Matrix<double, Rows, 3> planar_part(const Eigen::Matrix<double, Rows, 6>& by_pose) {
  Eigen::Matrix<double, Rows, 3> part;
  part << by_pose.template leftCols<2>(), by_pose.template rightCols<1>();
  return part;
}

/// A pose changed by its six numbers, see BodyPose.
BodyPose moved(const BodyPose& pose, const Eigen::Matrix<double, 6, 1>& step) {
  BodyPose result = pose;
  result.position += step.head<3>();
  result.rotation = rotation_exp(step.tail<3>()).toRotationMatrix() * pose.rotation;
  return result;
}

/// Central differences of a function of a pose.
template <int Rows>
Eigen::Matrix<double, Rows, 6> differentiate_pose(
    const std::function<Eigen::Matrix<double, Rows, 1>(const BodyPose&)>& function, const BodyPose& at) {
  Eigen::Matrix<double, Rows, 6> jacobian;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Matrix<double, 6, 1> step = kStep * Eigen::Matrix<double, 6, 1>::Unit(i);
    jacobian.col(i) = (function(moved(at, step)) - function(moved(at, -step))) / (2.0 * kStep);
  }
  return jacobian;
}

BodyPose tilted(const Eigen::Vector3d& position, const Eigen::Vector3d& turn) {
  return common::Pose3{position, rotation_exp(turn)};
}

class ProjectionTest : public ::testing::Test {
 protected:
  Camera camera_ = make_camera("cam0", 0.5);
  Camera anchor_camera_ = make_camera("cam1", 0.3, -0.1, 0.2);
  Pose2 row_shift_{0.004, -0.001, 0.008};
  Pose2 robot_{0.7, -0.4, 0.25};
  Pose2 anchor_pose_{-0.1, 0.2, 0.4};
  Anchor anchor_{&anchor_camera_, Pose2{-0.002, 0.001, -0.006}};
  BodyPose tilted_robot_ = tilted({0.7, -0.4, 0.1}, {0.2, -0.1, 0.25});
  BodyPose tilted_anchor_ = tilted({-0.1, 0.2, -0.2}, {-0.1, 0.15, 0.4});
  BodyPose tilted_row_shift_ = tilted({0.004, -0.001, 0.003}, {0.006, -0.004, 0.008});
};

TEST_F(ProjectionTest, APointStraightAheadAppearsInTheMiddle) {
  const Camera forward = make_camera("cam0", 0.0, 0.1, 0.0);

  const auto projection = project_cartesian(forward, {}, Pose2{1.0, 2.0, std::numbers::pi / 2}, {1.0, 7.0, 0.7});

  ASSERT_TRUE(projection);
  EXPECT_NEAR(projection->point.norm(), 0.0, 1e-12);
}

TEST_F(ProjectionTest, APointBehindTheCameraIsNotSeen) {
  const Camera forward = make_camera("cam0", 0.0);

  EXPECT_FALSE(project_cartesian(forward, {}, {}, {-3.0, 0.0, 0.7}));
}

TEST_F(ProjectionTest, CartesianJacobiansMatchFiniteDifferences) {
  const Eigen::Vector3d point(3.5, 1.6, 1.4);
  const auto projection = project_cartesian(camera_, row_shift_, robot_, point);
  ASSERT_TRUE(projection);

  const auto by_robot = differentiate<2>(
      [&](const Eigen::Vector3d& v) { return project_cartesian(camera_, row_shift_, to_pose(v), point)->point; },
      robot_.vector());
  const auto by_point = differentiate<2>(
      [&](const Eigen::Vector3d& v) { return project_cartesian(camera_, row_shift_, robot_, v)->point; }, point);

  EXPECT_LT((planar_part(projection->wrt_robot) - by_robot).norm(), 1e-7);
  EXPECT_LT((projection->wrt_landmark - by_point).norm(), 1e-7);
  EXPECT_EQ(projection->wrt_anchor.norm(), 0.0);
}

TEST_F(ProjectionTest, DerivativesByTheScaleOfTheLeverArmMatchFiniteDifferences) {
  const Eigen::Vector3d point(3.5, 1.6, 1.4);
  const Eigen::Vector3d landmark(0.12, -0.2, 0.3);
  const double scale = 1.7;
  const auto cartesian = [&](double log_scale) {
    return *project_cartesian(camera_, row_shift_, robot_, point, std::exp(log_scale));
  };
  const auto anchored = [&](double log_scale) {
    return *project_anchored(camera_, row_shift_, robot_, anchor_, anchor_pose_, landmark, std::exp(log_scale));
  };
  const auto place = [&](double log_scale) {
    return to_cartesian(anchor_, anchor_pose_, landmark, std::exp(log_scale));
  };
  const double at = std::log(scale);

  const Eigen::Vector2d by_cartesian = (cartesian(at + kStep).point - cartesian(at - kStep).point) / (2.0 * kStep);
  const Eigen::Vector2d by_anchored = (anchored(at + kStep).point - anchored(at - kStep).point) / (2.0 * kStep);
  const Eigen::Vector3d by_place = (place(at + kStep).position - place(at - kStep).position) / (2.0 * kStep);

  EXPECT_LT((cartesian(at).wrt_lever_scale - by_cartesian).norm(), 1e-7);
  EXPECT_LT((anchored(at).wrt_lever_scale - by_anchored).norm(), 1e-7);
  EXPECT_LT((place(at).wrt_lever_scale - by_place).norm(), 1e-7);
}

TEST_F(ProjectionTest, InverseDepthJacobiansMatchFiniteDifferences) {
  for (const double rho : {0.5, 0.05, 0.0, -0.02}) {
    const Eigen::Vector3d landmark(0.12, -0.2, rho);
    const auto projection = project_anchored(camera_, row_shift_, robot_, anchor_, anchor_pose_, landmark);
    ASSERT_TRUE(projection) << rho;

    const auto by_robot = differentiate<2>(
        [&](const Eigen::Vector3d& v) {
          return project_anchored(camera_, row_shift_, to_pose(v), anchor_, anchor_pose_, landmark)->point;
        },
        robot_.vector());
    const auto by_anchor = differentiate<2>(
        [&](const Eigen::Vector3d& v) {
          return project_anchored(camera_, row_shift_, robot_, anchor_, to_pose(v), landmark)->point;
        },
        anchor_pose_.vector());
    const auto by_landmark = differentiate<2>(
        [&](const Eigen::Vector3d& v) {
          return project_anchored(camera_, row_shift_, robot_, anchor_, anchor_pose_, v)->point;
        },
        landmark);

    EXPECT_LT((planar_part(projection->wrt_robot) - by_robot).norm(), 1e-7) << rho;
    EXPECT_LT((planar_part(projection->wrt_anchor) - by_anchor).norm(), 1e-7) << rho;
    EXPECT_LT((projection->wrt_landmark - by_landmark).norm(), 1e-7) << rho;
  }
}

TEST_F(ProjectionTest, TheCartesianPointOfAnInverseDepthLandmarkAppearsWhereTheLandmarkDoes) {
  const Eigen::Vector3d landmark(0.12, -0.2, 0.4);

  const CartesianPoint point = to_cartesian(anchor_, anchor_pose_, landmark);
  const auto from_point = project_cartesian(camera_, row_shift_, robot_, point.position);
  const auto from_landmark = project_anchored(camera_, row_shift_, robot_, anchor_, anchor_pose_, landmark);

  ASSERT_TRUE(from_point && from_landmark);
  EXPECT_LT((from_point->point - from_landmark->point).norm(), 1e-12);
}

TEST_F(ProjectionTest, ConversionJacobiansMatchFiniteDifferences) {
  const Eigen::Vector3d landmark(0.12, -0.2, 0.4);
  const CartesianPoint point = to_cartesian(anchor_, anchor_pose_, landmark);

  const auto by_anchor =
      differentiate<3>([&](const Eigen::Vector3d& v) { return to_cartesian(anchor_, to_pose(v), landmark).position; },
                       anchor_pose_.vector());
  const auto by_landmark = differentiate<3>(
      [&](const Eigen::Vector3d& v) { return to_cartesian(anchor_, anchor_pose_, v).position; }, landmark);

  EXPECT_LT((planar_part(point.wrt_anchor) - by_anchor).norm(), 1e-7);
  EXPECT_LT((point.wrt_landmark - by_landmark).norm(), 1e-6);
}

TEST_F(ProjectionTest, JacobiansByFreePosesMatchFiniteDifferences) {
  const Eigen::Vector3d point(3.5, 1.6, 1.4), landmark(0.12, -0.2, 0.3);
  const auto cartesian = [&](const BodyPose& robot) {
    return project_cartesian(camera_, tilted_row_shift_, robot, point);
  };
  const auto anchored = [&](const BodyPose& robot, const BodyPose& anchor_pose) {
    return project_anchored(camera_, tilted_row_shift_, robot, anchor_, anchor_pose, landmark);
  };
  const auto place = [&](const BodyPose& anchor_pose) { return to_cartesian(anchor_, anchor_pose, landmark); };
  ASSERT_TRUE(cartesian(tilted_robot_) && anchored(tilted_robot_, tilted_anchor_));

  const auto by_robot = differentiate_pose<2>([&](const BodyPose& p) { return cartesian(p)->point; }, tilted_robot_);
  const auto anchored_by_robot =
      differentiate_pose<2>([&](const BodyPose& p) { return anchored(p, tilted_anchor_)->point; }, tilted_robot_);
  const auto by_anchor =
      differentiate_pose<2>([&](const BodyPose& p) { return anchored(tilted_robot_, p)->point; }, tilted_anchor_);
  const auto place_by_anchor =
      differentiate_pose<3>([&](const BodyPose& p) { return place(p).position; }, tilted_anchor_);

  EXPECT_LT((cartesian(tilted_robot_)->wrt_robot - by_robot).norm(), 1e-7);
  EXPECT_LT((anchored(tilted_robot_, tilted_anchor_)->wrt_robot - anchored_by_robot).norm(), 1e-7);
  EXPECT_LT((anchored(tilted_robot_, tilted_anchor_)->wrt_anchor - by_anchor).norm(), 1e-7);
  EXPECT_LT((place(tilted_anchor_).wrt_anchor - place_by_anchor).norm(), 1e-7);
}

TEST_F(ProjectionTest, LinearityIndexFallsWithTheUncertaintyOfTheDepth) {
  const Eigen::Vector3d first(0, 0, 0), second(0.5, 0, 0), point(0.2, 3.0, 0);

  EXPECT_GT(linearity_index(first, second, point, 0.33, 0.1), linearity_index(first, second, point, 0.33, 0.01));
  EXPECT_NEAR(linearity_index(first, first, point, 1.0 / point.norm(), 0.01), 4.0 * 0.01 * point.norm(), 1e-9);
  EXPECT_TRUE(std::isinf(linearity_index(first, second, point, -0.1, 0.01)));
}

}  // namespace
}  // namespace slamfuse::visual_slam
