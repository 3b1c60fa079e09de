// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/floor_speed.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "common/pose2.hpp"
#include "visual_slam/feature_simulation.hpp"
#include "visual_slam/floor_scene.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;
using testing::FloorScene;

constexpr double kSeconds = 0.2;
constexpr double kHeading = 0.3;  // [rad] in which the scene is driven through
constexpr common::Nanoseconds kStart = 1'700'000'000'000'000'000;
constexpr common::Nanoseconds kFrame = 200'000'000;

using Points = std::vector<Eigen::Vector3d>;

/// What is read from two pictures between which the robot drives this way and turns so far.
std::optional<FloorSpeed::Reading> read(const FloorScene& scene, const Camera& camera, double way, double turn,
                                        const TurnByWay& known_turn, const Points& standing = {},
                                        const FloorSpeedOptions& options = {}) {
  FloorSpeed speed(options, 1);
  const Pose2 before{1.0, -2.0, kHeading};
  EXPECT_FALSE(speed.read(0, camera, scene.picture(camera, before), kStart, {})) << "there is nothing to compare with";
  speed.moved(kSeconds, way / kSeconds, known_turn);
  const cv::Mat picture = scene.picture(camera, before * common::exp_se2({way, 0.0, turn}));
  return speed.read(0, camera, picture, kStart + kFrame, standing);
}

std::optional<FloorSpeed::Reading> read(const FloorScene& scene, const Camera& camera, double way, double turn) {
  return read(scene, camera, way, turn, TurnByWay(turn));
}

TEST(FloorSpeed, ReadsTheWayAheadAndBackAndInTurns) {
  for (const double yaw : {0.0, 0.9}) {
    const Camera camera = testing::make_camera("cam0", yaw);
    for (const auto& [way, turn] : {std::pair{0.08, 0.0}, {0.2, 0.15}, {0.05, -0.1}, {0.0, 0.0}, {-0.03, 0.0}}) {
      const auto reading = read({}, camera, way, turn);
      ASSERT_TRUE(reading) << yaw << ' ' << turn << ' ' << way;
      EXPECT_NEAR(reading->speed * kSeconds, way, 0.003) << yaw << ' ' << turn;
      EXPECT_NEAR(reading->seconds, kSeconds, 1e-9);
    }
  }
}

TEST(FloorSpeed, TheTurnMayComeInParts) {
  const Camera camera = testing::make_camera("cam0", 0.9);
  const FloorScene scene;
  FloorSpeed speed({}, 2);
  speed.read(0, camera, scene.picture(camera, {}), kStart, {});
  speed.moved(kSeconds / 2.0, 0.5, TurnByWay(0.06));
  speed.moved(kSeconds / 2.0, 0.5, TurnByWay(0.04));
  const auto reading =
      speed.read(0, camera, scene.picture(camera, common::exp_se2({0.1, 0.0, 0.1})), kStart + kFrame, {});
  ASSERT_TRUE(reading);
  EXPECT_NEAR(reading->speed * kSeconds, 0.1, 0.003);
}

// At 30 Hz several steps lie between the pictures that are compared, and what is told is the speed of the last.
TEST(FloorSpeed, TellsTheSpeedOfTheLastStep) {
  const Camera camera = testing::make_camera("cam0", 0.0);
  const FloorScene scene;
  FloorSpeed speed({}, 1);
  speed.read(0, camera, scene.picture(camera, {}), kStart, {});
  speed.moved(kSeconds / 2.0, 0.3, TurnByWay(0.0));
  EXPECT_FALSE(speed.read(0, camera, scene.picture(camera, {0.03, 0.0, 0.0}), kStart + kFrame / 4, {}));
  speed.moved(kSeconds / 2.0, 0.5, TurnByWay(0.0));
  const auto reading = speed.read(0, camera, scene.picture(camera, {0.08, 0.0, 0.0}), kStart + kFrame, {});
  ASSERT_TRUE(reading);
  EXPECT_NEAR(reading->speed, 0.5, 0.015);
}

TEST(FloorSpeed, AFloorWithoutTextureTellsNothing) {
  FloorScene scene;
  scene.floor = [](double, double) { return 120.0; };
  EXPECT_FALSE(read(scene, testing::make_camera("cam0", 0.0), 0.1, 0.0));
}

// Which way a striped floor moves along its stripes nobody can tell.
TEST(FloorSpeed, StripesAlongTheWayTellNothing) {
  FloorScene scene;
  scene.floor = [](double x, double y) {
    return 120.0 + 80.0 * std::sin(60.0 * (y * std::cos(kHeading) - x * std::sin(kHeading)));
  };
  EXPECT_FALSE(read(scene, testing::make_camera("cam0", 0.0), 0.1, 0.0));
}

// Tiles look the same after a whole tile.
TEST(FloorSpeed, APatternThatRepeatsAlongTheWayTellsNothing) {
  FloorScene scene;
  scene.floor = [](double x, double y) {
    const double along = x * std::cos(kHeading) + y * std::sin(kHeading);
    const double across = y * std::cos(kHeading) - x * std::sin(kHeading);
    return 120.0 + 60.0 * std::sin(90.0 * along) * std::sin(90.0 * across);
  };
  EXPECT_FALSE(read(scene, testing::make_camera("cam0", 0.0), 0.1, 0.0));
}

TEST(FloorSpeed, AWallIsNoFloor) {
  int readings = 0;
  for (const double distance : {1.6, 2.2, 3.0}) {
    FloorScene scene;
    scene.wall = 1.0 + distance;
    const auto reading = read(scene, testing::make_camera("cam0", 0.0), 0.1, 0.0);
    if (!reading) continue;
    ++readings;
    EXPECT_NEAR(reading->speed * kSeconds, 0.1, 0.005) << distance;
  }
  EXPECT_GE(readings, 1) << "there is floor before the farthest";
}

TEST(FloorSpeed, PicturesTooNearOrTooFarApartAreNotCompared) {
  const Camera camera = testing::make_camera("cam0", 0.0);
  const FloorScene scene;
  const cv::Mat first = scene.picture(camera, {});
  const cv::Mat second = scene.picture(camera, {0.05, 0.0, 0.0});
  FloorSpeed speed({}, 1);
  speed.read(0, camera, first, kStart, {});
  EXPECT_FALSE(speed.read(0, camera, second, kStart + kFrame / 4, {})) << "less than a tenth of a second";
  const auto reading = speed.read(0, camera, second, kStart + kFrame, {});
  ASSERT_TRUE(reading) << "the first picture is still the one to compare with";
  EXPECT_NEAR(reading->speed * kSeconds, 0.05, 0.003);
  EXPECT_FALSE(speed.read(0, camera, first, kStart + 10 * kFrame, {})) << "after a gap";
  EXPECT_FALSE(speed.read(0, camera, first, kStart, {})) << "of another time";
  EXPECT_TRUE(speed.read(0, camera, second, kStart + kFrame, {})) << "which goes on";
}

TEST(FloorSpeed, ReadsNothingWhenSwitchedOffOrWithTheCameraOnTheFloor) {
  FloorSpeedOptions off;
  off.enabled = false;
  EXPECT_FALSE(read({}, testing::make_camera("cam0", 0.0), 0.1, 0.0, TurnByWay(0.0), {}, off));
  Camera low = testing::make_camera("cam0", 0.0);
  low.t_base_camera.z() = 0.0;
  EXPECT_FALSE(FloorSpeed({}, 1).read(0, low, cv::Mat(480, 640, CV_8UC1, cv::Scalar(100)), kStart, {}));
}

// Of features followed it is known how far the robot has turned if it has driven this or that way.
TEST(FloorSpeed, TheTurnMayHangOnTheWay) {
  const Camera camera = testing::make_camera("cam0", 0.9);
  const testing::EvenDrive drive{.seconds = kSeconds, .way = 0.15, .turn = 0.12};
  testing::Noise noise(1);
  const TurnByWay turn(camera, testing::follow(camera, drive, 60, noise), {kSeconds, 0.0}, -0.05, 0.25, 0.0);
  const auto reading = read({}, camera, drive.way, drive.turn, turn);
  ASSERT_TRUE(reading);
  EXPECT_NEAR(reading->speed * kSeconds, drive.way, 0.004);
  const auto ignorant = read({}, camera, drive.way, drive.turn, TurnByWay(0.0));
  EXPECT_TRUE(!ignorant || std::abs(ignorant->speed * kSeconds - drive.way) > 0.02) << "it takes the turn";
}

// Points in all the directions a camera looks in, so far before its optical centre.
Points row_of_points(const Camera& camera, double yaw, double distance, double height) {
  Points points;
  for (double direction = -0.8; direction <= 0.8; direction += 0.1) {
    const Eigen::Vector2d along(std::cos(yaw + direction), std::sin(yaw + direction));
    const Eigen::Vector2d at = camera.t_base_camera.head<2>() + distance * along;
    points.emplace_back(at.x(), at.y(), height);
  }
  return points;
}

Points together(Points points, const Points& others) {
  points.insert(points.end(), others.begin(), others.end());
  return points;
}

/// A board from 0 to 0.75 m high, nearer than any floor in the picture.
Points board(const Camera& camera, double yaw) {
  Points points;
  for (const double height : {0.15, 0.35, 0.55, 0.75}) {
    points = together(points, row_of_points(camera, yaw, 1.4, height));
  }
  return points;
}

TEST(FloorSpeed, WhatStandsBeforeTheFloorHidesIt) {
  const Camera camera = testing::make_camera("cam0", 0.0);
  EXPECT_FALSE(read({}, camera, 0.1, 0.0, TurnByWay(0.0), board(camera, 0.0)));
}

TEST(FloorSpeed, WhatStandsElsewhereHidesNoFloor) {
  const Camera camera = testing::make_camera("cam0", 0.0);
  const auto bare = read({}, camera, 0.1, 0.0);
  ASSERT_TRUE(bare);
  // The line of sight to the farthest floor looked at is 0.53 m high where the table is.
  const std::pair<const char*, Points> cases[] = {
      {"beside and behind", board(camera, 3.14)},
      {"a table is looked under", row_of_points(camera, 0.0, 1.4, 0.8)},
      {"farther than the floor seen", row_of_points(camera, 0.0, 6.0, 0.1)},
      {"on the floor's own place, below the line of sight", row_of_points(camera, 0.0, 1.4, 0.0)},
  };
  for (const auto& [name, standing] : cases) {
    const auto reading = read({}, camera, 0.1, 0.0, TurnByWay(0.0), standing);
    ASSERT_TRUE(reading) << name;
    EXPECT_NEAR(reading->speed, bare->speed, 1e-12) << name;
  }
}

// A bed looks as the floor does, but nearer: the way seems longer by h / (h - z).
TEST(FloorSpeed, ABedTellsTooLongAWayUnlessItIsKnownToStandThere) {
  const Camera camera = testing::make_camera("cam0", 0.0);
  FloorScene bed;
  bed.height = 0.3;
  const auto fooled = read(bed, camera, 0.1, 0.0);
  ASSERT_TRUE(fooled);
  EXPECT_NEAR(fooled->speed * kSeconds, 0.1 * 0.7 / 0.4, 0.01);
  Points on_it;
  for (double distance = 0.9; distance < 4.0; distance += 0.15) {
    on_it = together(on_it, row_of_points(camera, 0.0, distance, bed.height));
  }
  EXPECT_FALSE(read(bed, camera, 0.1, 0.0, TurnByWay(0.0), on_it));
}

}  // namespace
}  // namespace slamfuse::visual_slam
