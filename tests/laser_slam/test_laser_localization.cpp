// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/laser_localization.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "laser_slam/pose_search.hpp"
#include "laser_slam/surface_map.hpp"
#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

using common::Pose2;
using common::TrackingState;
using ::testing::HasSubstr;

constexpr common::Nanoseconds kPeriod = common::kNanosecondsPerSecond / 10;

/// Walls as cells, the space within the outer box free: as a perfect mapper would draw it.
common::OccupancyGrid draw(const testing::Walls& walls, double x0, double y0, double x1, double y1) {
  common::OccupancyGrid grid;
  grid.resolution = 0.05;
  grid.origin = {x0 - 0.2, y0 - 0.2};
  grid.width = static_cast<int>((x1 - x0 + 0.4) / 0.05);
  grid.height = static_cast<int>((y1 - y0 + 0.4) / 0.05);
  grid.cells.assign(static_cast<std::size_t>(grid.width * grid.height), common::OccupancyGrid::kUnknown);
  const auto at = [&](double x, double y) -> std::int8_t& {
    const int column = static_cast<int>((x - grid.origin.x()) / 0.05);
    const int row = static_cast<int>((y - grid.origin.y()) / 0.05);
    return grid.cells[static_cast<std::size_t>(row * grid.width + column)];
  };
  for (double x = x0; x < x1; x += 0.04) {
    for (double y = y0; y < y1; y += 0.04) at(x, y) = 0;
  }
  for (const auto& [a, b] : walls) {
    const int steps = static_cast<int>((b - a).norm() / 0.01);
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector2d p = a + (b - a) * (static_cast<double>(i) / std::max(1, steps));
      at(p.x(), p.y()) = 100;
    }
  }
  return grid;
}

LocalizationMap room_map() { return {"room", draw(testing::room(), -3.03, -2.02, 5.02, 4.01), {}}; }

/// A plain rectangle: turned by half it looks the same.
testing::Walls rectangle() {
  testing::Walls walls;
  testing::add_box(walls, -4.03, -2.52, 4.03, 2.52);
  return walls;
}

/// A robot in a world, one scan each 0.1 s, with 1 cm of range noise and odometry that drifts by 3 percent.
class Robot {
 public:
  Robot(testing::Walls walls, const LocalizationMap& map, std::uint64_t seed = 1)
      : walls_(std::move(walls)), laser_(testing::full_circle_laser()), noise_(99, 0) {
    auto module = LaserLocalization::create(LaserSlamOptions{}, "laser0", laser_, map, seed);
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
  Robot robot(testing::room(), room_map());
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
    Robot robot(testing::room(), room_map());
    robot.truth = start;
    EXPECT_EQ(robot.step({}).state, TrackingState::kLost);
    const int found = robot.drive(100, TrackingState::kTracking, {0.02, 0.0, 0.06});
    EXPECT_GT(found, 3) << "some driving is needed";
    EXPECT_LT(robot.error(), 0.05);
  }
}

TEST(LaserLocalization, ClaimsNothingWhileItStands) {
  Robot robot(testing::room(), room_map());
  robot.truth = {1.0, 0.5, 0.2};
  EXPECT_EQ(robot.drive(60, TrackingState::kTracking, {}), -1);
}

TEST(LaserLocalization, NoticesThatItWasCarriedAndFindsItselfAgain) {
  Robot robot(testing::room(), room_map());
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
  Robot robot(rectangle(), {"rectangle", draw(rectangle(), -4.03, -2.52, 4.03, 2.52), {}});
  robot.truth = {1.5, 0.7, 0.4};
  EXPECT_EQ(robot.drive(200, TrackingState::kTracking, {0.04, 0.0, 0.06}), -1);
}

TEST(LaserLocalization, BecomesUncertainWhereScansCannotTellWhetherItWasCarried) {
  Robot robot(rectangle(), {"rectangle", draw(rectangle(), -4.03, -2.52, 4.03, 2.52), {}});
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
  Robot robot(crowded, room_map());
  robot.truth = {1.0, 0.5, 0.2};
  EXPECT_NE(robot.drive(60, TrackingState::kTracking), -1);
  robot.drive(40);
  EXPECT_EQ(robot.estimate.state, TrackingState::kTracking);
  EXPECT_LT(robot.error(), 0.05);
}

TEST(LaserLocalization, StaysLostOutsideTheMap) {
  Robot robot(testing::ring(), room_map());
  robot.truth = {0.0, 5.0, 1.5};
  EXPECT_EQ(robot.drive(80, TrackingState::kTracking, {0.03, 0.0, 0.0}), -1);
}

TEST(LaserLocalization, RelocaliseForgetsThePoseAndResetBeginsAnEpochInTheSameMap) {
  Robot robot(testing::room(), room_map());
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
  Robot robot(testing::room(), room_map());
  robot.truth = {1.0, 0.5, 0.2};
  robot.module().execute(common::SetPose{{-2.0, 3.0, 2.5}, Eigen::Vector3d(0.01, 0.01, 0.01).asDiagonal()});
  EXPECT_NE(robot.step({}).state, TrackingState::kTracking);
  ASSERT_NE(robot.drive(100, TrackingState::kTracking), -1);
  EXPECT_LT(robot.error(), 0.05);
}

TEST(LaserLocalization, KnowsInHindsightWhereItBegan) {
  Robot robot(testing::room(), room_map());
  robot.truth = {1.0, 0.5, 0.2};
  const Pose2 begin = robot.truth;
  robot.step({});
  ASSERT_NE(robot.drive(100, TrackingState::kTracking), -1);
  const auto path = robot.module().final_trajectory();
  ASSERT_EQ(path.size(), robot.estimates.size());
  EXPECT_LT(testing::distance(path.front().pose, begin), 0.1);
}

TEST(LaserLocalization, DoesTheSameTwiceAndDependsOnTheSeedOnlyInside) {
  Robot one(testing::room(), room_map(), 7), two(testing::room(), room_map(), 7);
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
  LocalizationMap empty = room_map();
  std::fill(empty.grid.cells.begin(), empty.grid.cells.end(), std::int8_t{0});
  const auto no_wall = create(empty);
  ASSERT_FALSE(no_wall);
  EXPECT_THAT(no_wall.error().message, HasSubstr("room"));
  LocalizationMap broken = room_map();
  broken.laser_state = "not a state";
  EXPECT_FALSE(create(broken));
  EXPECT_FALSE(create(LocalizationMap{}));
}

TEST(PoseSearch, FindsThePoseAmongTheBestOfAWholeMap) {
  const LocalizationMap map = room_map();
  const LikelihoodField field(map.grid, 1.0);
  const PoseSearch search(field, BeamModelOptions{}, PoseSearchOptions{});
  const Pose2 truth{3.3, 1.4, -2.2};
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 90; ++i) {
    const double bearing = i * 2.0 * M_PI / 90.0;
    const double range = testing::cast(testing::room(), truth.translation(), truth.theta + bearing);
    points.emplace_back(range * std::cos(bearing), range * std::sin(bearing));
  }
  const auto found = search.search(points);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(testing::distance(found.front().pose, truth), 0.08);
  EXPECT_LT(std::abs(common::angle_difference(found.front().pose.theta, truth.theta)), 0.04);
  EXPECT_TRUE(std::is_sorted(found.begin(), found.end(), [](const PoseCandidate& a, const PoseCandidate& b) {
    return a.log_likelihood > b.log_likelihood;
  }));
  EXPECT_TRUE(search.search({}).empty());
}

TEST(SurfaceMap, KnowsWallsWhereverTheGridsCornerLies) {
  common::OccupancyGrid grid;
  grid.resolution = 0.1;
  grid.width = 3;
  grid.height = 2;
  grid.origin = {-7.13, 2.52};
  grid.cells = {0, 100, -1, 0, 0, 0};
  const GridMap map = surface_map(grid, MapOptions{});
  const Surface surface = map.surface_at({-6.98, 2.57}, 2);
  ASSERT_GT(surface.weight, 0.0);
  EXPECT_NEAR(surface.mean.x(), -6.98, 1e-4);
  EXPECT_NEAR(surface.mean.y(), 2.57, 1e-4);
  EXPECT_EQ(map.surface_at({-6.5, 3.2}, 2).weight, 0.0);
}

}  // namespace
}  // namespace slamfuse::laser_slam
