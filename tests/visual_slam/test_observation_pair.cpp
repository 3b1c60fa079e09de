// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/observation_pair.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "visual_slam/bearing_simulation.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using testing::make_camera;
using Vector6 = Eigen::Matrix<double, 6, 1>;

BodyPose moved(const BodyPose& pose, const Vector6& step) {
  BodyPose result = pose;
  result.position += step.head<3>();
  result.rotation = rotation_exp(step.tail<3>()).toRotationMatrix() * pose.rotation;
  return result;
}

class ObservationPairTest : public ::testing::Test {
 protected:
  /// The pair of sights of a point of the map, without noise.
  ObservationPair sights(const Eigen::Vector3d& point, const BodyPose& first, const BodyPose& second) const {
    ObservationPair pair;
    pair.first_camera = &first_camera_;
    pair.second_camera = &second_camera_;
    pair.first = {.point = project_cartesian(first_camera_, row_shift_, first, point)->point,
                  .sigma = 0.002,
                  .row_shift = row_shift_};
    pair.second = {
        .point = project_cartesian(second_camera_, {}, second, point)->point, .sigma = 0.002, .row_shift = {}};
    pair.motion = first.inverse() * second;
    return pair;
  }

  /// Both sights by a camera across the way: of a point beside it the depth alone is uncertain.
  void look_left() {
    first_camera_ = second_camera_ = make_camera("cam0", std::numbers::pi / 2, 0.0, 0.0);
    row_shift_ = {};
  }

  Camera first_camera_ = make_camera("cam0", 0.6), second_camera_ = make_camera("cam1", 0.3, -0.1, 0.2);
  BodyPose row_shift_ = common::Pose2{0.004, -0.001, 0.008};
  BodyPose start_ = common::Pose3{{0.2, -0.1, 0.05}, rotation_exp({0.05, -0.1, 0.2})};
  Eigen::Vector3d point_{3.5, 2.0, 1.2};
};

TEST_F(ObservationPairTest, TheRaysMeetAtThePoint) {
  const BodyPose second = common::Pose3{{0.9, -0.3, 0.1}, rotation_exp({-0.1, 0.1, 0.3})};
  const ObservationPair pair = sights(point_, start_, second);

  const auto at = intersect(pair);
  ASSERT_TRUE(at);
  const auto point = point_of_pair(pair, *at, start_);

  ASSERT_TRUE(point);
  EXPECT_LT((point->position - point_).norm(), 1e-9);
}

TEST_F(ObservationPairTest, WithoutParallaxNothingMeets) {
  ObservationPair pair = sights(point_, start_, start_);
  pair.second_camera = &first_camera_;
  pair.second = pair.first;

  EXPECT_FALSE(intersect(pair));
}

TEST_F(ObservationPairTest, TheDerivativesOfThePlaceMatchFiniteDifferences) {
  const BodyPose second = common::Pose3{{0.9, -0.3, 0.1}, rotation_exp({-0.1, 0.1, 0.3})};
  const ObservationPair pair = sights(point_, start_, second);
  const auto at = intersect(pair);
  ASSERT_TRUE(at);
  const auto place = [&](const BodyPose& first, const BodyPose& later, ObservationPair changed) {
    changed.motion = first.inverse() * later;
    Intersection here = *intersect(changed);
    return point_of_pair(changed, here, first)->position;
  };
  constexpr double kStep = 1e-6;
  const auto point = point_of_pair(pair, *at, start_);
  ASSERT_TRUE(point);

  for (int i = 0; i < 6; ++i) {
    const Vector6 step = kStep * Vector6::Unit(i);
    const Eigen::Vector3d by_first =
        (place(moved(start_, step), second, pair) - place(moved(start_, -step), second, pair)) / (2.0 * kStep);
    const Eigen::Vector3d by_second =
        (place(start_, moved(second, step), pair) - place(start_, moved(second, -step), pair)) / (2.0 * kStep);
    EXPECT_LT((point->wrt_anchor.col(i) - by_first).norm(), 1e-5 * (1.0 + by_first.norm())) << i;
    EXPECT_LT((point->wrt_robot.col(i) - by_second).norm(), 1e-5 * (1.0 + by_second.norm())) << i;
  }
  ObservationPair larger = pair, smaller = pair;
  larger.lever_scale = std::exp(kStep);
  smaller.lever_scale = std::exp(-kStep);
  const Eigen::Vector3d by_scale = (place(start_, second, larger) - place(start_, second, smaller)) / (2.0 * kStep);
  EXPECT_LT((point->wrt_lever_scale - by_scale).norm(), 1e-5);
}

TEST_F(ObservationPairTest, TheDivergenceFallsWithTheBaseline) {
  look_left();
  double last = std::numeric_limits<double>::infinity();
  for (const double way : {0.02, 0.25, 0.5, 1.0}) {
    const ObservationPair pair = sights({0.5, 4.0, 1.0}, {}, common::Pose2{way, 0.0, 0.0});
    const auto at = intersect(pair);
    ASSERT_TRUE(at);
    const double divergence = divergence_from_gaussian(pair, *at, 500);
    EXPECT_TRUE(divergence < last || (std::isinf(divergence) && std::isinf(last))) << way;
    EXPECT_GT(divergence, 0.0) << way;
    last = divergence;
  }
  EXPECT_LT(last, 0.01);
}

TEST_F(ObservationPairTest, TheDivergenceIsThatOfAnUncertainDepth) {
  look_left();
  ObservationPair pair = sights({0.0, 4.0, 0.7}, {}, common::Pose2{1.0, 0.0, 0.0});
  pair.first.sigma = pair.second.sigma = 0.01;
  const double relative = std::sqrt(2.0) * 0.01 * 4.0 / 1.0;

  const double divergence = divergence_from_gaussian(pair, *intersect(pair), 4000);

  EXPECT_NEAR(divergence, 5.5 * relative * relative, 0.15 * 5.5 * relative * relative);
}

TEST_F(ObservationPairTest, AnUncertainMotionMakesThePairIllConditioned) {
  look_left();
  ObservationPair pair = sights({0.5, 4.0, 1.0}, {}, common::Pose2{0.5, 0.0, 0.0});
  const auto at = intersect(pair);
  ASSERT_TRUE(at);
  const double before = divergence_from_gaussian(pair, *at, 500);
  pair.motion_covariance = 0.03 * 0.03 * Eigen::Matrix<double, 6, 6>::Identity();

  EXPECT_GT(divergence_from_gaussian(pair, *at, 500), 3.0 * before);
}

FilterOptions delayed() {
  FilterOptions options;
  options.pixel_sigma = testing::BearingSimulation::kPixelSigma;
  options.initialisation = InitialisationKind::kWellConditionedPair;
  return options;
}

/// A gentle curve of 2.5 m: while a robot turns quickly it does not know its motion well enough for a pair.
std::vector<common::Pose2> curve() {
  std::vector<common::Pose2> path(1);
  for (int i = 0; i < 40; ++i) path.push_back(path.back() * common::exp_se2({0.0625, 0.0, 0.01}));
  return path;
}

TEST(DelayedInitialisation, LandmarksWaitOutsideTheStateAndEnterAsPoints) {
  testing::BearingSimulation simulation(3, 1, curve(), {});
  Ekf filter(delayed(), {});
  const int empty = filter.state().size();

  simulation.step(filter);
  const std::size_t waiting = filter.landmark_count();
  EXPECT_GT(waiting, 10U);
  EXPECT_EQ(filter.state().size(), empty + 3) << "only the pose they were seen from";
  while (!simulation.done()) simulation.step(filter);

  int points = 0;
  for (LandmarkId id = 0; id < 300; ++id) points += filter.has(id) && filter.map_point(id) ? 1 : 0;
  EXPECT_GT(points, 20);
  EXPECT_LT(simulation.error_of(filter).head<2>().norm(), 0.1);
}

TEST(DelayedInitialisation, WrongMatchesDoNotEnter) {
  testing::BearingSimulation simulation(11, 2, testing::circle_path(100), {});
  simulation.outliers_every = 8;
  Ekf filter(delayed(), {});

  while (!simulation.done()) simulation.step(filter);

  ASSERT_GT(simulation.outliers_made, 100);
  EXPECT_LT(simulation.error_of(filter).head<2>().norm(), 0.15);
}

}  // namespace
}  // namespace slamfuse::visual_slam
