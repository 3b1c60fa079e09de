// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/ekf.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "visual_slam/bearing_simulation.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;
using testing::BearingSimulation;
using testing::make_camera;

constexpr double kPixelSigma = BearingSimulation::kPixelSigma;
constexpr common::Nanoseconds kFrame = BearingSimulation::kFrame;

/// A robot driving circles in a room.
BearingSimulation simulate(unsigned seed, int cameras, int images = 200) {
  return {seed, cameras, testing::circle_path(images), {}};
}

FilterOptions filter_options() {
  FilterOptions options;
  options.pixel_sigma = kPixelSigma;
  return options;
}

TEST(Ekf, StartsAtTheOriginOfItsMap) {
  const Ekf filter(filter_options(), {});

  EXPECT_EQ(filter.pose().vector().norm(), 0.0);
  EXPECT_LT(filter.pose_covariance().norm(), 1e-6);
}

TEST(Ekf, ALandmarkStartsOnItsRayAtTheInitialDepthAndIsPredictedWhereItWasSeen) {
  Ekf filter(filter_options(), {});
  const Camera camera = make_camera("cam0", 0.4);
  const Bearing bearing = make_bearing(camera, {200.0, 300.0}, kPixelSigma, Eigen::Vector3d::Zero());

  filter.add_landmark(7, camera, bearing, 1);

  const std::optional<Prediction> prediction = filter.predict_bearing(camera, 7, {});
  ASSERT_TRUE(prediction);
  EXPECT_LT((prediction->point - bearing.point).norm(), 1e-9);
  EXPECT_FALSE(filter.map_point(7));
  const std::optional<Eigen::Vector3d> likely = filter.likely_position(7);
  ASSERT_TRUE(likely);
  const Eigen::Vector3d in_camera = camera.R_base_camera.transpose() * (*likely - camera.t_base_camera);
  EXPECT_NEAR(in_camera.z(), 1.0 / filter_options().initial_inverse_depth, 1e-9);
  EXPECT_EQ(filter.past_poses().size(), 1U);
}

TEST(Ekf, TheAnchorPoseGoesWithItsLastLandmark) {
  Ekf filter(filter_options(), {});
  const Camera camera = make_camera("cam0", 0.4);
  const int size = filter.state().size();
  filter.add_landmark(1, camera, make_bearing(camera, {200.0, 300.0}, 1.0, Eigen::Vector3d::Zero()), 1);
  filter.add_landmark(2, camera, make_bearing(camera, {400.0, 300.0}, 1.0, Eigen::Vector3d::Zero()), 1);
  EXPECT_EQ(filter.state().size(), size + 9);
  const LandmarkId both[] = {1, 2};

  filter.remove(both);

  EXPECT_EQ(filter.state().size(), size);
  EXPECT_TRUE(filter.past_poses().empty());
}

TEST(Ekf, VisionKeepsTheErrorFarBelowThatOfTheOdometry) {
  BearingSimulation seeing = simulate(3, 1), blind = simulate(3, 0);
  Ekf with_camera(filter_options(), {}), odometry_only(filter_options(), {});

  for (int i = 0; i < 200; ++i) {
    seeing.step(with_camera);
    blind.step(odometry_only);
  }

  const double by_vision = seeing.error_of(with_camera).head<2>().norm();
  EXPECT_LT(by_vision, 0.1);
  EXPECT_LT(with_camera.pose_covariance()(2, 2), 0.05 * odometry_only.pose_covariance()(2, 2));
}

TEST(Ekf, LandmarksBecomeCartesianNearTheirTruePlaces) {
  BearingSimulation simulation = simulate(5, 2);
  Ekf filter(filter_options(), {});
  for (int i = 0; i < 100; ++i) simulation.step(filter);

  int cartesian = 0;
  for (LandmarkId id = 0; id < 300; ++id) {
    if (filter.has(id) && filter.map_point(id)) {
      ++cartesian;
      EXPECT_EQ(*filter.likely_position(id), filter.map_point(id)->position);
    }
  }

  EXPECT_GT(cartesian, 30);
}

TEST(Ekf, TwoCamerasAreBetterThanOneThroughTheSameInterface) {
  double one = 0.0, two = 0.0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    BearingSimulation with_one = simulate(seed, 1), with_two = simulate(seed, 2);
    Ekf filter_one(filter_options(), {}), filter_two(filter_options(), {});
    for (int i = 0; i < 120; ++i) {
      with_one.step(filter_one);
      with_two.step(filter_two);
    }
    one += filter_one.pose_covariance().topLeftCorner<2, 2>().trace();
    two += filter_two.pose_covariance().topLeftCorner<2, 2>().trace();
  }
  EXPECT_LT(two, one);
}

TEST(Ekf, WrongMatchesDoNotEnter) {
  BearingSimulation simulation = simulate(11, 2);
  simulation.outliers_every = 8;
  Ekf filter(filter_options(), {});

  for (int i = 0; i < 100; ++i) simulation.step(filter);

  ASSERT_GT(simulation.outliers_made, 100);
  EXPECT_LT(simulation.outliers_accepted, simulation.outliers_made / 20);
  EXPECT_LT(simulation.error_of(filter).head<2>().norm(), 0.15);
}

/// NEES of the pose averaged over runs and over images spread along them; 3 is right.
double mean_nees(const FilterOptions& options, int cameras) {
  constexpr unsigned kRuns = 20;
  double nees = 0.0;
  int samples = 0;
  for (unsigned seed = 100; seed < 100 + kRuns; ++seed) {
    BearingSimulation simulation = simulate(seed, cameras);
    simulation.max_landmarks = 50;
    Ekf filter(options, {});
    for (int image = 1; !simulation.done(); ++image) {
      simulation.step(filter);
      if (image % 20 != 0) continue;
      nees += simulation.nees(filter);
      ++samples;
    }
  }
  return nees / samples;
}

TEST(Ekf, WhatItBelievesOfItsErrorIsRightOverManyRuns) {
  // The 95 % band of 20 independent runs is [2.0, 4.2]; the images of a run are not independent.
  for (const int cameras : {1, 2}) {
    const double nees = mean_nees(filter_options(), cameras);
    EXPECT_GT(nees, 2.0) << cameras << " cameras";
    EXPECT_LT(nees, 4.2) << cameras << " cameras";
  }
}

TEST(Ekf, LinearisingAgainAtTheCorrectedStateMakesItOverconfident) {
  FilterOptions iterated = filter_options();
  iterated.iterations = 2;
  EXPECT_GT(mean_nees(iterated, 1), 1.3 * mean_nees(filter_options(), 1));
}

TEST(Ekf, KeyframesStayWithinTheirLimit) {
  Ekf filter(filter_options(), {});

  for (int i = 0; i < 50; ++i) {
    filter.predict({common::to_seconds(kFrame), {0.1, 0.0, 0.0}});
    filter.add_keyframe(i * kFrame, 10);
  }

  EXPECT_EQ(filter.past_poses().size(), 10U);
  EXPECT_EQ(filter.past_poses().front().stamp, 0);
  EXPECT_EQ(filter.past_poses().back().stamp, 49 * kFrame);
}

TEST(Ekf, SettingThePoseKeepsTheMapAndForgetsWhatHasNoDepth) {
  BearingSimulation simulation = simulate(5, 1);
  Ekf filter(filter_options(), {});
  for (int i = 0; i < 60; ++i) simulation.step(filter);
  const std::size_t before = filter.landmark_count();

  const std::vector<LandmarkId> gone = filter.set_pose({1.0, 2.0, 0.5}, 0.01 * Eigen::Matrix3d::Identity());

  EXPECT_NEAR(filter.pose().x, 1.0, 1e-12);
  EXPECT_NEAR(filter.pose_covariance()(0, 0), 0.01, 1e-12);
  EXPECT_EQ(filter.landmark_count(), before - gone.size());
  for (LandmarkId id = 0; id < 300; ++id) {
    EXPECT_TRUE(!filter.has(id) || filter.is_cartesian(id));
  }
}

MotionOptions without_wheels() {
  MotionOptions options;
  options.model = MotionModelKind::kConstantVelocity;
  options.constant_velocity.lever_scale_sigma = 0.0;
  return options;
}

constexpr double kTold = 0.5;  // [m/s]

/// A filter that is certain of its speed.
Ekf driving_filter() {
  Ekf filter(filter_options(), without_wheels());
  for (int i = 0; i < 20; ++i) filter.correct_speed(kTold, 1e-3);
  filter.predict({common::to_seconds(kFrame), {}});
  for (int i = 0; i < 20; ++i) filter.correct_speed(kTold, 1e-3);
  return filter;
}

double speed_of(const Ekf& filter) { return filter.twist()->linear.x(); }

/// Points ahead of base_link whose places are well known.
const Eigen::Vector3d kAhead[] = {{2.0, 0.3, 0.4}, {3.0, -0.8, 1.0}, {1.5, 0.1, -0.3}};
constexpr LandmarkId kPoints[] = {0, 1, 2};

void add_points(Ekf& filter) {
  filter.add_keyframe(1, 10);
  for (const LandmarkId id : kPoints) {
    const Eigen::Vector2d at = filter.pose() * Eigen::Vector2d(kAhead[id].head<2>());
    filter.add_point(id, {at.x(), at.y(), kAhead[id].z()}, *filter.keyframe_at(1), 1e-6 * Eigen::Matrix3d::Identity());
  }
}

double distance(const Ekf& filter, LandmarkId id) {
  const Eigen::Vector2d here = filter.pose().translation();
  return (*filter.likely_position(id) - Eigen::Vector3d(here.x(), here.y(), 0.0)).norm();
}

/// A camera where base_link is, so that what is seen grows about its optical centre.
Camera central_camera() {
  common::CameraCalibration calibration = make_camera("cam0", 0.0).calibration;
  calibration.T_base_camera.translation.setZero();
  return {"cam0", calibration};
}

TEST(Ekf, NoBearingSeesTheScaleDrift) {
  Ekf filter = driving_filter();
  const Camera camera = central_camera();
  add_points(filter);
  filter.add_landmark(3, camera, make_bearing(camera, {200.0, 300.0}, 1.0, Eigen::Vector3d::Zero()), 2);
  filter.add_landmark(4, camera, make_bearing(camera, {400.0, 150.0}, 1.0, Eigen::Vector3d::Zero()), 2);
  const LandmarkId all[] = {0, 1, 2, 3, 4};
  std::vector<Eigen::Matrix2d> before;
  for (const LandmarkId id : all) before.push_back(filter.predict_bearing(camera, id, {})->covariance);

  filter.let_scale_drift(all, 0.05);

  for (const LandmarkId id : all) {
    const Eigen::Matrix2d after = filter.predict_bearing(camera, id, {})->covariance;
    EXPECT_LT((after - before[static_cast<std::size_t>(id)]).norm(), 1e-12) << id;
  }
}

TEST(Ekf, AfterTheScaleHasDriftedASpeedThatIsToldMovesTheLandmarksInProportion) {
  for (const double more : {0.02, -0.03}) {
    Ekf filter = driving_filter();
    const Camera camera = central_camera();
    add_points(filter);
    filter.add_landmark(3, camera, make_bearing(camera, {200.0, 300.0}, 1.0, Eigen::Vector3d::Zero()), 2);
    const LandmarkId drifting[] = {0, 1, 3};
    std::vector<double> before;
    for (LandmarkId id = 0; id < 4; ++id) before.push_back(distance(filter, id));

    filter.let_scale_drift(drifting, 0.05);
    ASSERT_TRUE(filter.correct_speed(kTold * (1.0 + more), 1e-4));

    EXPECT_NEAR(speed_of(filter), kTold * (1.0 + more), 1e-4);
    for (const LandmarkId id : drifting) {
      EXPECT_NEAR(distance(filter, id) / before[static_cast<std::size_t>(id)], 1.0 + more, 0.002) << id;
    }
    EXPECT_NEAR(distance(filter, 2) / before[2], 1.0, 1e-3) << "it was not said to drift";
  }
}

// A certain speed and certain landmarks share what they are told by how uncertain they are.
TEST(Ekf, ASpeedThatIsUncertainOfItsOwnTakesItsShareOfWhatIsTold) {
  Ekf filter = driving_filter();
  add_points(filter);
  const double before = distance(filter, 0);
  filter.let_scale_drift(kPoints, 0.05);
  filter.doubt_speed(0.05 * kTold);

  ASSERT_TRUE(filter.correct_speed(1.04 * kTold, 1e-4));

  EXPECT_NEAR(speed_of(filter), 1.04 * kTold, 1e-4);
  EXPECT_NEAR(distance(filter, 0) / before, 1.02, 0.002) << "half";
}

TEST(Ekf, WheelsLetNoScaleDriftAndNoSpeedBeDoubted) {
  Ekf filter(filter_options(), {});
  filter.predict({common::to_seconds(kFrame), {0.1, 0.0, 0.0}});
  add_points(filter);
  const Eigen::MatrixXd before = filter.state().covariance();

  filter.let_scale_drift(kPoints, 0.05);
  filter.doubt_speed(0.3);

  EXPECT_EQ((filter.state().covariance() - before).norm(), 0.0);
}

TEST(Ekf, ASpeedThatIsDoubtedMayBeToldAnew) {
  Ekf filter = driving_filter();
  ASSERT_FALSE(filter.correct_speed(2.0 * kTold, 0.01));
  EXPECT_NEAR(speed_of(filter), kTold, 1e-6);

  filter.doubt_speed(0.3);

  EXPECT_TRUE(filter.correct_speed(2.0 * kTold, 0.01));
  EXPECT_NEAR(speed_of(filter), 2.0 * kTold, 0.01);
}

constexpr double kGuessed = 0.3;  // [m/s]

/// What the speed of a filter that guesses it becomes by landmarks just begun, when the robot is faster.
double speed_by_new_landmarks(bool metres_are_told) {
  Ekf filter(filter_options(), without_wheels());
  filter.set_metres_are_told(metres_are_told);
  filter.correct_speed(kGuessed, 1e-3);
  filter.doubt_speed(0.3);
  const Camera camera = make_camera("cam0", 0.9);
  std::vector<Measurement> now;
  for (int i = 0; i < 12; ++i) {
    const LandmarkId id = i;
    const Eigen::Vector2d pixel(220.0 + 100.0 * (i % 4), 60.0 + 160.0 * (i / 4));
    const Bearing before = make_bearing(camera, pixel, 1.0, Eigen::Vector3d::Zero());
    filter.add_landmark(id, camera, before, 1);
    const Eigen::Vector3d at = 2.5 * before.point.homogeneous() - camera.R_base_camera.transpose().col(0) * 0.1;
    now.push_back({id, make_bearing(camera, *camera.calibration.project(at), 1.0, Eigen::Vector3d::Zero())});
  }
  filter.predict({common::to_seconds(kFrame), {}});
  EXPECT_GT(filter.update(camera, now).inliers, 6);
  return speed_of(filter);
}

// Their parallax is taken for a hundred times as noisy, not left out, so that a little remains.
TEST(Ekf, WhileMetresAreToldLandmarksOfUnknownDepthTeachNextToNoSpeed) {
  const double learnt = speed_by_new_landmarks(false) - kGuessed;
  EXPECT_GT(learnt, 0.1) << "they must, while nobody else does";
  EXPECT_LT(std::abs(speed_by_new_landmarks(true) - kGuessed), 0.15 * learnt);
}

TEST(Ekf, ItsUnitIsAMetreByWheelsOrByBeingTold) {
  EXPECT_TRUE(Ekf(filter_options(), {}).is_metric());
  Ekf filter(filter_options(), without_wheels());
  EXPECT_FALSE(filter.is_metric());
  filter.set_metres_are_told(true);
  EXPECT_TRUE(filter.is_metric());
  filter.set_metres_are_told(false);
  EXPECT_FALSE(filter.is_metric());
}

TEST(Ekf, ASpeedThatIsToldNeedNotBeHeldTo) {
  Ekf told = driving_filter(), held = driving_filter();
  told.set_metres_are_told(true);
  for (Ekf* filter : {&told, &held}) filter->predict({common::to_seconds(kFrame), {}});

  EXPECT_TRUE(told.correct_speed(kTold + 0.2, 0.01));
  EXPECT_FALSE(held.correct_speed(kTold + 0.2, 0.01));
}

TEST(Ekf, KnowsTheDepthOfPointsButNotOfLandmarksJustBegunOrWaiting) {
  const Camera camera = make_camera("cam0", 0.4);
  const Bearing bearing = make_bearing(camera, {200.0, 300.0}, kPixelSigma, Eigen::Vector3d::Zero());
  Ekf filter(filter_options(), {});
  filter.add_landmark(7, camera, bearing, 2);
  filter.add_fixed_landmark(8, {{2.0, 0.0, 0.5}, 0.01 * Eigen::Matrix3d::Identity()});
  add_points(filter);
  EXPECT_FALSE(filter.knows_depth(7));
  EXPECT_TRUE(filter.knows_depth(8));
  EXPECT_TRUE(filter.knows_depth(0));

  FilterOptions delayed = filter_options();
  delayed.initialisation = InitialisationKind::kWellConditionedPair;
  Ekf waiting(delayed, {});
  waiting.add_landmark(7, camera, bearing, 2);
  EXPECT_FALSE(waiting.knows_depth(7));
}

TEST(Ekf, LearnsTheDepthOfLandmarksItDrivesPast) {
  BearingSimulation simulation = simulate(5, 1);
  FilterOptions options = filter_options();
  options.linearity_index = 1e-9;  // none becomes a point
  Ekf filter(options, {});
  for (int i = 0; i < 40; ++i) simulation.step(filter);

  int known = 0;
  for (LandmarkId id = 0; id < 300; ++id) known += filter.has(id) && filter.knows_depth(id) ? 1 : 0;
  EXPECT_GT(known, 10);
}

}  // namespace
}  // namespace slamfuse::visual_slam
