// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/ekf.hpp"

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

}  // namespace
}  // namespace slamfuse::visual_slam
