// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/laser_localization.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drawn_map.hpp"
#include "laser_slam/surface_map.hpp"
#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

using common::Pose2;
using common::TrackingState;
using ::testing::HasSubstr;

constexpr common::Nanoseconds kPeriod = common::kNanosecondsPerSecond / 10;

/// A plain rectangle: turned by half it looks the same.
testing::Walls rectangle() {
  testing::Walls walls;
  testing::add_box(walls, -4.03, -2.52, 4.03, 2.52);
  return walls;
}

/// A robot in a world, one scan each 0.1 s, with 1 cm of range noise and odometry that drifts by 3 percent.
class Robot {
 public:
  Robot(testing::Walls walls, const LocalizationMap& map, std::uint64_t seed = 1, const LaserSlamOptions& options = {})
      : walls_(std::move(walls)), laser_(testing::full_circle_laser()), noise_(99, 0) {
    auto module = LaserLocalization::create(options, "laser0", laser_, map, seed);
    EXPECT_TRUE(module) << (module ? "" : module.error().message);
    if (module) module_ = std::move(*module);
  }

  LaserLocalization& module() { return *module_; }

  const common::PoseEstimate& step(const Pose2& increment) {
    truth = truth * increment;
    odometry_ = odometry_ * Pose2{1.03 * increment.x, increment.y, 0.97 * increment.theta};
    return look();
  }

  /// Somebody lifts the robot and puts it down elsewhere; no scans for 3 s, the wheels stand.
  const common::PoseEstimate& carry_to(const Pose2& pose) {
    truth = pose;
    stamp_ += 30 * kPeriod;
    return look();
  }

  /// Drives in an arc for so many scans, and tells the first at which the state was `state` (-1: never).
  int drive(int scans, std::optional<TrackingState> until = std::nullopt, const Pose2& increment = {0.04, 0.0, 0.04}) {
    for (int i = 0; i < scans; ++i) {
      step(increment);
      if (until && estimate.state == *until) return i;
    }
    return -1;
  }

  double error() const { return testing::distance(estimate.pose, truth); }

  Pose2 truth;
  common::PoseEstimate estimate;
  std::vector<common::PoseEstimate> estimates;

 private:
  const common::PoseEstimate& look() {
    module_->process(common::WheelOdometry{stamp_, "odom0", odometry_, 0.0, 0.0});
    const auto processed = module_->process(testing::scan_at(walls_, laser_, stamp_, truth, &noise_));
    EXPECT_TRUE(processed.estimate) << processed.rejected.value_or("");
    estimate = processed.estimate.value_or(common::PoseEstimate{});
    estimates.push_back(estimate);
    stamp_ += kPeriod;
    return estimate;
  }

  testing::Walls walls_;
  common::LaserCalibration laser_;
  RandomStream noise_;
  std::unique_ptr<LaserLocalization> module_;
  Pose2 odometry_;
  common::Nanoseconds stamp_ = 0;
};

TEST(LaserLocalization, TracksFromAGivenPose) {
  Robot robot(testing::room(), testing::room_map());
  robot.truth = {1.0, 0.5, 0.2};
  robot.module().execute(common::SetPose{{1.15, 0.4, 0.25}, Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal()});
  robot.drive(80);
  double worst = 0.0;
  for (std::size_t i = 10; i < robot.estimates.size(); ++i) {
    EXPECT_EQ(robot.estimates[i].state, TrackingState::kTracking) << i;
  }
  worst = std::max(worst, robot.error());
  EXPECT_LT(worst, 0.05);
  EXPECT_LT(std::abs(common::angle_difference(robot.estimate.pose.theta, robot.truth.theta)), 0.02);
  EXPECT_GT(robot.estimate.covariance.diagonal().minCoeff(), 0.0);
}

TEST(LaserLocalization, IsLostUntilAGlobalStartIsProvedByDriving) {
  for (const Pose2& start : {Pose2{1.0, 0.5, 0.2}, Pose2{-2.0, 2.5, -2.0}, Pose2{3.5, -1.0, 1.5}}) {
    Robot robot(testing::room(), testing::room_map());
    robot.truth = start;
    EXPECT_EQ(robot.step({}).state, TrackingState::kLost);
    const int found = robot.drive(100, TrackingState::kTracking, {0.02, 0.0, 0.06});
    EXPECT_GT(found, 3) << "some driving is needed";
    EXPECT_LT(robot.error(), 0.05);
  }
}

TEST(LaserLocalization, ClaimsNothingWhileItStands) {
  Robot robot(testing::room(), testing::room_map());
  robot.truth = {1.0, 0.5, 0.2};
  EXPECT_EQ(robot.drive(60, TrackingState::kTracking, {}), -1);
}

TEST(LaserLocalization, NoticesThatItWasCarriedAndFindsItselfAgain) {
  Robot robot(testing::room(), testing::room_map());
  robot.truth = {1.0, 0.5, 0.2};
  ASSERT_NE(robot.drive(100, TrackingState::kTracking), -1);
  robot.carry_to({-1.8, 2.6, -1.2});
  const int lost = robot.estimate.state == TrackingState::kLost ? 0 : robot.drive(20, TrackingState::kLost);
  EXPECT_NE(lost, -1) << "within 2 s";
  ASSERT_NE(robot.drive(100, TrackingState::kTracking, {0.02, 0.0, 0.06}), -1);
  EXPECT_LT(robot.error(), 0.05);
  const bool told = std::any_of(robot.estimates.begin(), robot.estimates.end(), [](const auto& estimate) {
    return std::any_of(estimate.events.begin(), estimate.events.end(),
                       [](const common::Event& event) { return event.kind == "lost"; });
  });
  EXPECT_TRUE(told);
}

TEST(LaserLocalization, DoesNotClaimOneOfTwoPlacesThatLookTheSame) {
  Robot robot(rectangle(), {"rectangle", testing::draw(rectangle(), -4.03, -2.52, 4.03, 2.52), {}});
  robot.truth = {1.5, 0.7, 0.4};
  EXPECT_EQ(robot.drive(200, TrackingState::kTracking, {0.04, 0.0, 0.06}), -1);
}

TEST(LaserLocalization, BecomesUncertainWhereScansCannotTellWhetherItWasCarried) {
  Robot robot(rectangle(), {"rectangle", testing::draw(rectangle(), -4.03, -2.52, 4.03, 2.52), {}});
  robot.truth = {1.5, 0.7, 0.4};
  robot.module().execute(common::SetPose{robot.truth, Eigen::Vector3d(0.01, 0.01, 0.001).asDiagonal()});
  robot.drive(30);
  EXPECT_EQ(robot.estimate.state, TrackingState::kTracking) << "where it came from tells the sides apart";
  robot.carry_to(robot.truth);
  EXPECT_NE(robot.estimate.state, TrackingState::kTracking) << "it may have been turned by half";
  EXPECT_GT(robot.estimate.covariance(0, 0), 0.5) << "the other side is as probable";
}

TEST(LaserLocalization, PutsUpWithPeople) {
  testing::Walls crowded = testing::room();
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(0.3, 2.0), Eigen::Vector2d(2.2, -0.9), Eigen::Vector2d(2.9, 1.1)}) {
    testing::add_box(crowded, p.x(), p.y(), p.x() + 0.45, p.y() + 0.45);
  }
  Robot robot(crowded, testing::room_map());
  robot.truth = {1.0, 0.5, 0.2};
  EXPECT_NE(robot.drive(60, TrackingState::kTracking), -1);
  robot.drive(40);
  EXPECT_EQ(robot.estimate.state, TrackingState::kTracking);
  EXPECT_LT(robot.error(), 0.05);
}

TEST(LaserLocalization, StaysLostOutsideTheMap) {
  Robot robot(testing::ring(), testing::room_map());
  robot.truth = {0.0, 5.0, 1.5};
  EXPECT_EQ(robot.drive(80, TrackingState::kTracking, {0.03, 0.0, 0.0}), -1);
}

TEST(LaserLocalization, RelocaliseForgetsThePoseAndResetBeginsAnEpochInTheSameMap) {
  Robot robot(testing::room(), testing::room_map());
  robot.truth = {1.0, 0.5, 0.2};
  ASSERT_NE(robot.drive(100, TrackingState::kTracking), -1);
  EXPECT_EQ(robot.estimate.map_epoch, 0U);
  robot.module().execute(common::Relocalise{});
  EXPECT_EQ(robot.step({}).state, TrackingState::kLost);
  EXPECT_FALSE(robot.module().final_trajectory().empty());
  robot.module().execute(common::Reset{});
  EXPECT_TRUE(robot.module().final_trajectory().empty());
  robot.step({});
  EXPECT_EQ(robot.estimate.state, TrackingState::kLost);
  EXPECT_EQ(robot.estimate.map_epoch, 1U);
  ASSERT_NE(robot.drive(100, TrackingState::kTracking), -1);
  EXPECT_LT(robot.error(), 0.05);
}

TEST(LaserLocalization, AWrongPoseFromOutsideIsNotBelievedForLong) {
  Robot robot(testing::room(), testing::room_map());
  robot.truth = {1.0, 0.5, 0.2};
  robot.module().execute(common::SetPose{{-2.0, 3.0, 2.5}, Eigen::Vector3d(0.01, 0.01, 0.01).asDiagonal()});
  EXPECT_NE(robot.step({}).state, TrackingState::kTracking);
  ASSERT_NE(robot.drive(100, TrackingState::kTracking), -1);
  EXPECT_LT(robot.error(), 0.05);
}

TEST(LaserLocalization, AnswersAPoseItCannotTakeWithAnEventAndGoesOn) {
  const Pose2 good{1.0, 0.5, 0.2};
  const Eigen::Matrix3d narrow = Eigen::Vector3d(0.01, 0.01, 0.001).asDiagonal();
  Eigen::Matrix3d indefinite = narrow;
  indefinite(0, 1) = indefinite(1, 0) = 1.0;
  const std::vector<common::SetPose> bad = {{{NAN, 0.0, 0.0}, narrow},
                                            {{0.0, 0.0, HUGE_VAL}, narrow},
                                            {{1e9, 0.0, 0.0}, narrow},
                                            {good, Eigen::Matrix3d::Constant(NAN)},
                                            {good, indefinite}};
  Robot robot(testing::room(), testing::room_map());
  robot.truth = good;
  robot.module().execute(common::SetPose{good, narrow});
  robot.drive(10);
  ASSERT_EQ(robot.estimate.state, TrackingState::kTracking);
  for (const common::SetPose& command : bad) {
    robot.module().execute(command);
    robot.step({0.04, 0.0, 0.04});
    ASSERT_EQ(robot.estimate.events.size(), 1U);
    EXPECT_EQ(robot.estimate.events[0].kind, "set_pose_refused");
    EXPECT_EQ(robot.estimate.state, TrackingState::kTracking) << "nothing else changed";
    EXPECT_LT(robot.error(), 0.05);
  }
}

TEST(LaserLocalization, TakesAWideCovarianceAtItsWordAndAHeadingBeyondAFullTurn) {
  Robot robot(testing::room(), testing::room_map());
  robot.truth = {1.0, 0.5, 0.2};
  robot.module().execute(common::SetPose{{1.4, 0.1, 0.2 + 2.0 * M_PI}, Eigen::Vector3d(0.25, 0.25, 0.07).asDiagonal()});
  EXPECT_NE(robot.step({}).state, TrackingState::kLost) << "told from outside, to be verified";
  ASSERT_NE(robot.drive(30, TrackingState::kTracking), -1);
  EXPECT_LT(robot.error(), 0.05);
}

TEST(LaserLocalization, RejectsOdometryThatIsImpossiblyFarAway) {
  Robot robot(testing::room(), testing::room_map());
  for (const double far : {1e300, -1e12, static_cast<double>(NAN)}) {
    EXPECT_TRUE(robot.module().process(common::WheelOdometry{0, "odom0", {0.0, far, 0.0}, 0.0, 0.0}).rejected);
  }
}

TEST(LaserLocalization, IsFoundSoonThoughTheWholeMapIsSearchedAgainMeanwhile) {
  Robot robot(testing::ring(), {"ring", testing::draw(testing::ring(), -1.0, -1.0, 13.0, 13.0), {}});
  robot.truth = {0.1, 2.0, 1.5};
  // 0.05 m a scan, and a search each second and 0.2 m: proved after 0.35 m and not much later.
  const int found = robot.drive(60, TrackingState::kTracking, {0.05, 0.0, 0.0});
  ASSERT_NE(found, -1);
  EXPECT_LT(found, 30);
  EXPECT_LT(robot.error(), 0.1);
}

TEST(LaserLocalization, TellsTheHypothesesOfTheLastScan) {
  Robot robot(rectangle(), {"rectangle", testing::draw(rectangle(), -4.03, -2.52, 4.03, 2.52), {}});
  robot.truth = {1.5, 0.7, 0.4};
  EXPECT_TRUE(robot.module().hypotheses().empty());
  robot.drive(20, std::nullopt, {0.04, 0.0, 0.06});
  const auto hypotheses = robot.module().hypotheses();
  ASSERT_GE(hypotheses.size(), 2U) << "turned by half it looks the same";
  double mass = 0.0;
  for (const Hypothesis& hypothesis : hypotheses) mass += hypothesis.mass;
  EXPECT_NEAR(mass, 1.0, 1e-9);
  const Pose2 turned{-robot.truth.x, -robot.truth.y, robot.truth.theta + M_PI};
  const double nearest = std::min(testing::distance(hypotheses.front().mean, robot.truth),
                                  testing::distance(hypotheses.front().mean, turned));
  EXPECT_LT(nearest, 0.15);
}

TEST(LaserLocalization, TakesMoreHypothesesThanParticles) {
  LaserSlamOptions options;
  options.localization.filter.max_particles = 100;
  options.localization.filter.min_particles = 10;
  options.localization.filter.least_mass = 0.0;
  options.localization.search.candidates = 1000;
  options.localization.search.kept_share = 0.05;
  Robot robot(testing::ring(), {"ring", testing::draw(testing::ring(), -1.0, -1.0, 13.0, 13.0), {}}, 1, options);
  robot.truth = {0.1, 2.0, 1.5};
  robot.step({});
  EXPECT_GT(robot.module().hypotheses().size(), 100U);
  for (const Hypothesis& hypothesis : robot.module().hypotheses()) EXPECT_GE(hypothesis.particles, 1);
  robot.drive(10, std::nullopt, {0.05, 0.0, 0.0});
  EXPECT_TRUE(robot.estimate.pose.is_finite());
}

TEST(LaserLocalization, KnowsInHindsightWhereItBegan) {
  Robot robot(testing::room(), testing::room_map());
  robot.truth = {1.0, 0.5, 0.2};
  const Pose2 begin = robot.truth;
  robot.step({});
  ASSERT_NE(robot.drive(100, TrackingState::kTracking), -1);
  const auto path = robot.module().final_trajectory();
  ASSERT_EQ(path.size(), robot.estimates.size());
  EXPECT_LT(testing::distance(path.front().pose, begin), 0.1);
}

TEST(LaserLocalization, DoesTheSameTwiceAndDependsOnTheSeedOnlyInside) {
  Robot one(testing::room(), testing::room_map(), 7), two(testing::room(), testing::room_map(), 7);
  for (Robot* robot : {&one, &two}) {
    robot->truth = {1.0, 0.5, 0.2};
    robot->drive(50);
  }
  ASSERT_EQ(one.estimates.size(), two.estimates.size());
  for (std::size_t i = 0; i < one.estimates.size(); ++i) {
    EXPECT_EQ(one.estimates[i].pose.vector(), two.estimates[i].pose.vector()) << i;
    EXPECT_EQ(one.estimates[i].covariance, two.estimates[i].covariance) << i;
    EXPECT_EQ(one.estimates[i].state, two.estimates[i].state) << i;
  }
}

TEST(LaserLocalization, RefusesAMapWithNothingInItAndABrokenState) {
  const auto create = [](const LocalizationMap& map) {
    return LaserLocalization::create(LaserSlamOptions{}, "laser0", testing::full_circle_laser(), map, 1);
  };
  LocalizationMap empty = testing::room_map();
  std::fill(empty.grid.cells.begin(), empty.grid.cells.end(), std::int8_t{0});
  const auto no_wall = create(empty);
  ASSERT_FALSE(no_wall);
  EXPECT_THAT(no_wall.error().message, HasSubstr("room"));
  LocalizationMap broken = testing::room_map();
  broken.laser_state = "not a state";
  EXPECT_FALSE(create(broken));
  EXPECT_FALSE(create(LocalizationMap{}));
}

TEST(LaserLocalization, RefusesMoreParticlesForOneHypothesisThanForAll) {
  LaserSlamOptions options;
  options.localization.filter.min_particles = 500;
  options.localization.filter.max_particles = 100;
  const auto made = LaserLocalization::create(options, "laser0", testing::full_circle_laser(), testing::room_map(), 1);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, HasSubstr("min_particles is 500; allowed is up to max_particles, which is 100"));
}

TEST(SurfaceMap, KnowsWallsWhereverTheGridsCornerLies) {
  common::OccupancyGrid grid;
  grid.resolution = 0.1;
  grid.width = 3;
  grid.height = 2;
  grid.origin = {-7.13, 2.52};
  grid.cells = {0, 100, -1, 0, 0, 0};
  const auto made = surface_map(grid, MapOptions{});
  ASSERT_TRUE(made);
  const GridMap& map = *made;
  const Surface surface = map.surface_at({-6.98, 2.57}, 2);
  ASSERT_GT(surface.weight, 0.0);
  EXPECT_NEAR(surface.mean.x(), -6.98, 1e-4);
  EXPECT_NEAR(surface.mean.y(), 2.57, 1e-4);
  EXPECT_EQ(map.surface_at({-6.5, 3.2}, 2).weight, 0.0);
}

TEST(SurfaceMap, RefusesAGridNoMapCanBe) {
  const auto refused = [](const std::function<void(common::OccupancyGrid&)>& spoil, const char* why) {
    common::OccupancyGrid grid;
    grid.width = grid.height = 2;
    grid.cells.assign(4, 100);
    ASSERT_TRUE(surface_map(grid, MapOptions{}));
    spoil(grid);
    const auto made = surface_map(grid, MapOptions{});
    ASSERT_FALSE(made) << why;
    EXPECT_THAT(made.error().message, HasSubstr(why));
    const auto localization = LaserLocalization::create(LaserSlamOptions{}, "laser0", testing::full_circle_laser(),
                                                        {"spoilt", std::move(grid), {}}, 1);
    ASSERT_FALSE(localization) << why;
    EXPECT_THAT(localization.error().message, HasSubstr("spoilt: "));
    EXPECT_THAT(localization.error().message, HasSubstr(why));
  };
  refused([](auto& grid) { grid.resolution = 0.0; }, "cells are 0 m wide");
  refused([](auto& grid) { grid.resolution = NAN; }, "cells are nan m wide");
  refused([](auto& grid) { grid.resolution = 1e-8; }, "allowed are 0.0001 m and more");
  refused([](auto& grid) { grid.cells.pop_back(); }, "has 3 cells");
  refused([](auto& grid) { grid.width = 0; }, "the grid is 0 x 2");
  refused([](auto& grid) { grid.origin.x() = 30000.0; }, "allowed is up to 20000 m");
  refused([](auto& grid) { grid.origin.y() = NAN; }, "allowed is up to 20000 m");
  // Larger than a map may be, though it fits in memory.
  refused(
      [](auto& grid) {
        grid.resolution = 0.0005;
        grid.width = 36'000'000;
        grid.height = 1;
        grid.cells.assign(static_cast<std::size_t>(grid.width), 100);
      },
      "allowed are up to 1048576 tiles");
}

}  // namespace
}  // namespace slamfuse::laser_slam
