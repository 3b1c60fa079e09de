// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/landmark_initialisation.hpp"

#include <gtest/gtest.h>

#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr double kSigma = 1.0;  // [px]

/// A camera at the map's origin that has seen a point, and moved aside by `baseline` since.
class LandmarkInitialisationTest : public ::testing::Test {
 protected:
  LandmarkInitialisationTest() {
    const Eigen::Matrix3d exact = 1e-10 * Eigen::Matrix3d::Identity();
    robot_ = state_.append(Eigen::Vector3d::Zero(), BlockKind::kPose, {}, exact);
    parameters_ = state_.append(Eigen::Vector3d::Zero(), BlockKind::kCalibration, {}, exact);
    landmark_.anchor_pose = state_.append(Eigen::Vector3d::Zero(), BlockKind::kPose, {}, exact);
    landmark_.anchor = {&camera_, {}};
  }

  MeasurementModel model() const { return {state_, robot_, parameters_, motion_, 0.4}; }

  Bearing bearing_of(const Eigen::Vector3d& point) const {
    const auto seen = project_cartesian(camera_, {}, body_pose(state_, robot_), point);
    const auto pixel = camera_.calibration.project(seen->point.homogeneous());
    return make_bearing(camera_, *pixel, kSigma, Eigen::Vector3d::Zero());
  }

  void move_aside(double baseline) { state_.mean(robot_) = Eigen::Vector3d(0.0, baseline, 0.0); }

  Camera camera_ = testing::make_camera("cam0", 0.0);
  OdometryMotion motion_{MotionOptions{}};
  State state_;
  BlockId robot_ = 0;
  BlockId parameters_ = 0;
  FilterLandmark landmark_;
  const Eigen::Vector3d point_{3.0, 0.2, 0.9};
};

TEST_F(LandmarkInitialisationTest, TheGuessedDepthIsOnTheRay) {
  const Bearing bearing = bearing_of(point_);
  landmark_.form = LandmarkForm::kInverseDepth;
  landmark_.block = enter_by_inverse_depth(state_, bearing, {0.5, 0.3});

  EXPECT_EQ(landmark_.numbers(state_), Eigen::Vector3d(bearing.point.x(), bearing.point.y(), 0.5));
  EXPECT_NEAR(state_.covariance(landmark_.block, landmark_.block)(2, 2), 0.09, 1e-12);
  EXPECT_LT((model().predict(camera_, landmark_, {})->point - bearing.point).norm(), 1e-12);
}

TEST_F(LandmarkInitialisationTest, BecomesAPointOnceItsDepthIsKnownWell) {
  landmark_.form = LandmarkForm::kInverseDepth;
  const double depth = (camera_.R_base_camera.transpose() * (point_ - camera_.t_base_camera)).z();
  landmark_.block = enter_by_inverse_depth(state_, bearing_of(point_), {1.0 / depth, 0.3});
  EXPECT_EQ(make_cartesian(state_, model(), landmark_, camera_, 0.1), Conversion::kNotYet);
  landmark_.block = enter_by_inverse_depth(state_, bearing_of(point_), {1.0 / depth, 0.001});
  EXPECT_EQ(make_cartesian(state_, model(), landmark_, camera_, 0.1), Conversion::kDone);

  EXPECT_EQ(landmark_.form, LandmarkForm::kPoint);
  EXPECT_LT((state_.mean(landmark_.block) - point_).norm(), 1e-9);
}

TEST_F(LandmarkInitialisationTest, AnInverseDepthClearlyBelowZeroIsNoPoint) {
  landmark_.form = LandmarkForm::kInverseDepth;
  landmark_.block = enter_by_inverse_depth(state_, bearing_of(point_), {-0.05, 0.1});
  EXPECT_EQ(make_cartesian(state_, model(), landmark_, camera_, 0.1), Conversion::kNotYet);
  landmark_.block = enter_by_inverse_depth(state_, bearing_of(point_), {-0.5, 0.1});
  EXPECT_EQ(make_cartesian(state_, model(), landmark_, camera_, 0.1), Conversion::kImpossible);
}

TEST_F(LandmarkInitialisationTest, APairEntersOnlyFromFarEnoughAside) {
  FilterOptions options;
  landmark_.form = LandmarkForm::kWaiting;
  landmark_.first = bearing_of(point_);
  landmark_.inverse_depth = 0.4;

  move_aside(0.01);
  EXPECT_EQ(pair_up(state_, model(), landmark_, camera_, bearing_of(point_), options), PairOutcome::kFits);
  move_aside(0.5);
  EXPECT_EQ(pair_up(state_, model(), landmark_, camera_, bearing_of(point_ + Eigen::Vector3d(0.0, 0.0, 0.3)), options),
            PairOutcome::kMisfit);
  EXPECT_EQ(pair_up(state_, model(), landmark_, camera_, bearing_of(point_), options), PairOutcome::kEntered);
  EXPECT_EQ(landmark_.form, LandmarkForm::kPoint);
  EXPECT_LT((state_.mean(landmark_.block) - point_).norm(), 0.02);
}

}  // namespace
}  // namespace slamfuse::visual_slam
