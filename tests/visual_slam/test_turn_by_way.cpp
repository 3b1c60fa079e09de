// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/turn_by_way.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "visual_slam/feature_simulation.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using testing::EvenDrive;
using testing::Noise;

constexpr double kSeconds = 0.2;
constexpr double kLeast = -0.05;
constexpr double kMost = 0.25;
constexpr double kOtherwise = 0.77;  // which no robot turns here
const double kRight = common::to_radians(0.12);
constexpr int kFeatures = 60;

EvenDrive drive(double way, double turn) { return {.seconds = kSeconds, .way = way, .turn = turn, .last_turn = turn}; }

TurnByWay turn_by(const Camera& camera, const std::vector<FollowedFeature>& features, double last_turn = 0.0) {
  return {camera, features, {kSeconds, last_turn / kSeconds}, kLeast, kMost, kOtherwise};
}

/// The worst error for the true way, of drives ahead, back, on the spot and in turns, by cameras mounted anywhere.
double worst_error(double yaw) {
  Noise noise(1);
  double worst = 0.0;
  for (const double arm : {0.0, 0.3, -0.2}) {
    const Camera camera = testing::make_camera("cam0", yaw, arm, 0.05);
    for (const auto& [way, turn] :
         {std::pair{0.1, 0.0}, {0.2, 0.15}, {0.1, -0.2}, {0.0, 0.25}, {0.0, -0.25}, {-0.04, 0.1}, {0.0, 0.0}}) {
      const TurnByWay found = turn_by(camera, testing::follow(camera, drive(way, turn), kFeatures, noise));
      worst = std::max(worst, std::abs(found(way) - turn));
    }
  }
  return worst;
}

TEST(TurnByWay, IsRightForTheTrueWay) {
  for (const double yaw : {0.0, 0.4, 0.9, 3.0}) EXPECT_LT(worst_error(yaw), kRight) << yaw;
}

// There driving moves the features as turning does, and only their rising and sinking tells one from the other.
TEST(TurnByWay, IsLessExactForACameraThatLooksAside) { EXPECT_LT(worst_error(-1.5), 3.0 * kRight); }

TEST(TurnByWay, AFifthOfTheFeaturesMayBeWrong) {
  Noise noise(2);
  for (const double yaw : {0.0, 0.9}) {
    const Camera camera = testing::make_camera("cam0", yaw);
    for (const auto& [way, turn] : {std::pair{0.1, 0.0}, {0.2, 0.15}, {0.0, -0.25}}) {
      auto features = testing::follow(camera, drive(way, turn), kFeatures, noise);
      for (std::size_t i = 0; i < features.size(); i += 5) {
        features[i].now = {640.0 * noise.uniform(), 480.0 * noise.uniform()};
      }
      EXPECT_NEAR(turn_by(camera, features)(way), turn, kRight) << yaw << ' ' << way;
    }
  }
}

// The rows of a rolling shutter see the robot at different times of its turn.
TEST(TurnByWay, KnowsOfTheRollingShutter) {
  Noise noise(3);
  Camera camera = testing::make_camera("cam0", 0.4);
  camera.calibration.readout = 0.03;
  for (const double turn : {0.2, -0.2}) {
    for (const double last_turn : {0.0, turn}) {
      EvenDrive turning = drive(0.04, turn);
      turning.last_turn = last_turn;
      const auto features = testing::follow(camera, turning, kFeatures, noise);
      EXPECT_NEAR(turn_by(camera, features, last_turn)(turning.way), turn, kRight) << last_turn;
    }
  }
}

TEST(TurnByWay, WithTooLittleToGoByItIsWhatWasGiven) {
  Noise noise(4);
  const Camera camera = testing::make_camera("cam0", 0.4);
  const auto features = testing::follow(camera, drive(0.1, 0.1), 8, noise);
  const std::vector<FollowedFeature> few(features.begin(), features.begin() + 7);
  const std::pair<const char*, TurnByWay> cases[] = {
      {"seven features", {camera, few, {kSeconds, 0.0}, kLeast, kMost, kOtherwise}},
      {"no time", {camera, features, {0.0, 0.0}, kLeast, kMost, kOtherwise}},
      {"no ways", {camera, features, {kSeconds, 0.0}, kMost, kMost, kOtherwise}},
      {"ways the wrong way round", {camera, features, {kSeconds, 0.0}, kMost, kLeast, kOtherwise}},
  };
  for (const auto& [name, turn] : cases) {
    for (const double way : {-1.0, kLeast, 0.0, 0.1, kMost, 3.0}) {
      EXPECT_EQ(turn(way), kOtherwise) << name << ' ' << way;
      EXPECT_EQ(turn.log_likelihood(way), 0.0) << name << ' ' << way;
    }
  }
  EXPECT_NEAR(turn_by(camera, features)(0.1), 0.1, common::to_radians(1.0)) << "eight are enough";
}

TEST(TurnByWay, OneTurnIsThatOfEveryWay) {
  const TurnByWay turn(0.3);
  for (const double way : {-1.0, 0.0, 0.5, 1.0, 7.0}) {
    EXPECT_EQ(turn(way), 0.3) << way;
    EXPECT_EQ(turn.log_likelihood(way), 0.0) << way;
  }
}

TEST(TurnByWay, BeyondTheWaysAskedForItIsThatOfTheLast) {
  Noise noise(5);
  const Camera camera = testing::make_camera("cam0", 0.9);
  const TurnByWay turn = turn_by(camera, testing::follow(camera, drive(0.1, 0.1), kFeatures, noise));
  ASSERT_NE(turn(kLeast), turn(kMost)) << "a camera that looks aside sees way and turn alike";
  EXPECT_EQ(turn(kLeast - 1.0), turn(kLeast));
  EXPECT_EQ(turn(kMost + 1.0), turn(kMost));
  EXPECT_EQ(turn.log_likelihood(kLeast - 1.0), turn.log_likelihood(kLeast));
  EXPECT_EQ(turn.log_likelihood(kMost + 1.0), turn.log_likelihood(kMost));
}

// Its camera, which is not where the robot turns, sees the way and the turn in different proportions for each way.
TEST(TurnByWay, ASharpTurnTellsTheWay) {
  Noise noise(6);
  for (const double yaw : {0.0, 0.4, 0.9}) {
    for (const double way : {0.04, 0.06, 0.08}) {
      const Camera camera = testing::make_camera("cam0", yaw, 0.3, 0.0);
      const TurnByWay turn = turn_by(camera, testing::follow(camera, drive(way, 0.25), kFeatures, noise));
      double best = kLeast;
      for (double tried = kLeast; tried <= kMost; tried += 0.005) {
        EXPECT_LE(turn.log_likelihood(tried), 0.0) << tried;
        if (turn.log_likelihood(tried) > turn.log_likelihood(best)) best = tried;
      }
      EXPECT_NEAR(best, way, 0.035) << yaw << ": two of the ways that were tried";
      EXPECT_GT(turn.log_likelihood(way), -3.0) << yaw << ' ' << way;
      EXPECT_LT(turn.log_likelihood(3.0 * way), turn.log_likelihood(way) - 10.0) << yaw << ' ' << way;
    }
  }
}

}  // namespace
}  // namespace slamfuse::visual_slam
