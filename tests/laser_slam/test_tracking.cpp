// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "laser_slam/ancestry.hpp"
#include "laser_slam/loop_detector.hpp"
#include "laser_slam/motion_predictor.hpp"
#include "laser_slam/path_log.hpp"
#include "laser_slam/tracking_monitor.hpp"
#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

using common::TrackingState;
constexpr common::Nanoseconds kSecond = common::kNanosecondsPerSecond;

TEST(LoopDetector, ClosesOnceOnEnteringOldGround) {
  LoopDetector loops{LoopDetectorOptions{}};
  EXPECT_FALSE(loops.closes(0.1, 20.0));
  EXPECT_TRUE(loops.closes(0.7, 21.0));
  EXPECT_FALSE(loops.closes(0.8, 22.0)) << "still on it";
  EXPECT_FALSE(loops.closes(0.1, 23.0));
  EXPECT_FALSE(loops.closes(0.7, 25.0)) << "left it only 3 m ago";
  EXPECT_FALSE(loops.closes(0.0, 26.0));
  EXPECT_TRUE(loops.closes(0.6, 40.0));
}

TEST(LoopDetector, DoesNotFireInTheFirstMetres) {
  LoopDetector loops{LoopDetectorOptions{}};
  EXPECT_FALSE(loops.closes(1.0, 2.0));
}

TEST(TrackingMonitor, BecomesLostOnlyAfterTheStatedTimeAndFoundOnClearAgreement) {
  TrackingMonitor monitor({0.45, 0.25, 2.0});
  monitor.add(0, 0.8);
  EXPECT_EQ(monitor.state(), TrackingState::kTracking);
  monitor.add(1 * kSecond, 0.1);
  EXPECT_EQ(monitor.state(), TrackingState::kUncertain);
  EXPECT_FALSE(monitor.may_map());
  monitor.add(3 * kSecond, 0.1);
  EXPECT_EQ(monitor.state(), TrackingState::kLost);
  EXPECT_TRUE(monitor.just_lost());
  monitor.add(4 * kSecond, 0.3);
  EXPECT_EQ(monitor.state(), TrackingState::kLost) << "doubtful agreement does not end it";
  EXPECT_FALSE(monitor.just_lost());
  monitor.add(5 * kSecond, 0.7);
  EXPECT_EQ(monitor.state(), TrackingState::kTracking);
  EXPECT_TRUE(monitor.just_found());
}

TEST(TrackingMonitor, ForgetsWhatTheLastScanDidWhenThePoseIsSet) {
  TrackingMonitor monitor({0.45, 0.25, 2.0});
  monitor.add(0, 0.1);
  monitor.add(2 * kSecond, 0.1);
  ASSERT_TRUE(monitor.just_lost());
  monitor.reset();
  EXPECT_FALSE(monitor.just_lost());
  monitor.add(3 * kSecond, 0.1);
  monitor.add(5 * kSecond, 0.1);
  monitor.add(6 * kSecond, 0.8);
  ASSERT_TRUE(monitor.just_found());
  monitor.reset();
  EXPECT_FALSE(monitor.just_found());
}

TEST(TrackingMonitor, KeepsItsStateWhereNothingIsKnownYet) {
  TrackingMonitor monitor({0.45, 0.25, 2.0});
  monitor.add(0, std::nullopt);
  EXPECT_EQ(monitor.state(), TrackingState::kTracking);
  monitor.add(1, 0.3);
  EXPECT_EQ(monitor.state(), TrackingState::kUncertain);
  EXPECT_TRUE(monitor.may_map());
}

TEST(Ancestry, FollowsParentsBackThroughResampling) {
  Ancestry ancestry;
  ancestry.record({{{0.0, 0.0, 0.0}, 0}, {{0.0, 1.0, 0.0}, 0}});
  ancestry.record({{{1.0, 0.0, 0.0}, 1}, {{1.0, 1.0, 0.0}, 1}});
  ancestry.record({{{2.0, 0.0, 0.0}, 1}, {{2.0, 1.0, 0.0}, 0}});
  const auto path = ancestry.path_of(1);
  ASSERT_EQ(path.size(), 3u);
  EXPECT_EQ(path[2].y, 1.0);
  EXPECT_EQ(path[1].y, 0.0);
  EXPECT_EQ(path[0].y, 1.0);
}

TEST(PathLog, SpreadsACorrectionEvenlyOverItsSegment) {
  PathLog log(common::kKeepAll);
  log.begin_segment(std::nullopt);
  log.add(0, {});
  log.add(1, {1.0, 0.0, 0.0});
  log.begin_segment(common::Pose2{2.0, 0.0, 0.0});
  log.add(2, {});
  log.add(3, {0.5, 0.0, 0.0});

  const auto path = log.compose({{0.0, 0.0, 0.0}, {2.0, 0.2, 0.0}});

  ASSERT_EQ(path.size(), 4u);
  EXPECT_EQ(path[0].pose.y, 0.0);
  EXPECT_NEAR(path[1].pose.x, 1.0, 1e-9);
  EXPECT_NEAR(path[1].pose.y, 0.1, 1e-9);
  EXPECT_NEAR(path[2].pose.y, 0.2, 1e-9);
  EXPECT_NEAR(path[3].pose.x, 2.5, 1e-9);
  EXPECT_EQ(path[3].stamp, 3);
}

TEST(PathLog, DoesNotBendThePathTowardsAPoseSetFromOutside) {
  PathLog log(common::kKeepAll);
  log.begin_segment(std::nullopt);
  log.add(0, {});
  log.add(1, {1.0, 0.0, 0.0});
  log.begin_segment(std::nullopt);
  const auto path = log.compose({{0.0, 0.0, 0.0}, {50.0, 0.0, 0.0}});
  EXPECT_NEAR(path[1].pose.x, 1.0, 1e-9);
}

TEST(PathLog, KeepsItsPosesRightWhereItIsThinned) {
  constexpr int kSegments = 500;
  constexpr int kPerSegment = 30;
  PathLog all(common::kKeepAll);
  PathLog thinned(1000);
  std::vector<common::Pose2> updates;
  common::Nanoseconds stamp = 0;
  for (int s = 0; s < kSegments; ++s) {
    updates.push_back({1.1 * s, 0.3, 0.0});
    for (PathLog* log : {&all, &thinned}) log->begin_segment(common::Pose2{1.0, 0.0, 0.0});
    for (int i = 0; i < kPerSegment; ++i) {
      stamp += kSecond / 10;
      for (PathLog* log : {&all, &thinned}) log->add(stamp, {i / 30.0, 0.0, 0.0});
    }
  }
  const auto complete = all.compose(updates);
  const auto path = thinned.compose(updates);
  ASSERT_EQ(complete.size(), static_cast<std::size_t>(kSegments * kPerSegment));
  EXPECT_LE(path.size(), 1000u);
  EXPECT_GT(path.size(), 450u);
  for (const auto& pose : path) {
    const auto& same = complete[static_cast<std::size_t>(pose.stamp / (kSecond / 10)) - 1];
    EXPECT_EQ(pose.stamp, same.stamp);
    EXPECT_EQ(pose.pose.x, same.pose.x);
  }
}

TEST(MotionPredictor, UsesOdometryAndElseTheLastSpeed) {
  MotionPredictor predictor{MotionModelOptions{}};
  predictor.start(0);
  predictor.finish(kSecond / 10, predictor.predict(kSecond / 10), {0.05, 0.0, 0.01});
  const MotionPrediction without = predictor.predict(2 * kSecond / 10);
  EXPECT_FALSE(without.from_odometry);
  EXPECT_NEAR(without.increment.x, 0.05, 1e-9);

  predictor.add({2 * kSecond / 10, "odom0", {7.0, 0.0, 0.0}, 0.0, 0.0});
  predictor.finish(2 * kSecond / 10, without, without.increment);
  predictor.add({3 * kSecond / 10, "odom0", {7.02, 0.0, 0.0}, 0.0, 0.0});
  const MotionPrediction with = predictor.predict(3 * kSecond / 10);
  EXPECT_TRUE(with.from_odometry);
  EXPECT_FALSE(with.suspicious);
  EXPECT_NEAR(with.increment.x, 0.02, 1e-9);
}

TEST(MotionPredictor, LetsOdometryCatchUpAfterAStall) {
  MotionPredictor predictor{MotionModelOptions{}};
  predictor.add({0, "odom0", {}, 0.0, 0.0});
  predictor.start(0);
  predictor.add({3 * kSecond, "odom0", {0.0, 0.0, 0.4}, 0.0, 0.0});
  const MotionPrediction stall = predictor.predict(3 * kSecond);
  predictor.finish(3 * kSecond, stall, stall.increment);
  const common::Nanoseconds next = 3 * kSecond + kSecond / 10;
  predictor.add({next, "odom0", {0.3, 0.0, 1.4}, 0.0, 0.0});
  const MotionPrediction made_up = predictor.predict(next);
  EXPECT_FALSE(made_up.suspicious);
  predictor.finish(next, made_up, made_up.increment);
  predictor.add({next + kSecond / 10, "odom0", {0.6, 0.0, 2.4}, 0.0, 0.0});
  EXPECT_TRUE(predictor.predict(next + kSecond / 10).suspicious) << "only once";
}

TEST(MotionPredictor, SuspectsOdometryTooFastToBeTrue) {
  MotionPredictor predictor{MotionModelOptions{}};
  predictor.add({0, "odom0", {}, 0.0, 0.0});
  predictor.start(0);
  predictor.add({kSecond / 10, "odom0", {5.0, 0.0, 0.0}, 0.0, 0.0});
  EXPECT_TRUE(predictor.predict(kSecond / 10).suspicious);
}

TEST(MotionPredictor, ForgetsItsSpeedOverALongGap) {
  MotionPredictor predictor{MotionModelOptions{}};
  predictor.start(0);
  predictor.finish(kSecond / 10, predictor.predict(kSecond / 10), {0.05, 0.0, 0.0});
  EXPECT_EQ(predictor.predict(5 * kSecond).increment.x, 0.0);
}

TEST(MotionPredictor, SettlesOnTheSpeedWhereSweepsFillTheTimeBetweenScans) {
  // A match fixes the middle of a sweep: an error of the speed the sweep is undone with moves the first beam's pose.
  MotionPredictor predictor{MotionModelOptions{}};
  constexpr double kSpeed = 0.4;
  constexpr common::Nanoseconds kStep = kSecond / 10;
  predictor.begin_sweep(0, kStep);
  predictor.start(0);
  double first_beam = 0.0;
  for (int scan = 1; scan <= 20; ++scan) {
    const common::Nanoseconds stamp = scan * kStep;
    const double assumed = predictor.begin_sweep(stamp, kStep).x();
    const double middle = kSpeed * common::to_seconds(stamp + kStep / 2);
    const double here = middle - assumed * common::to_seconds(kStep / 2);
    predictor.finish(stamp, predictor.predict(stamp), {here - first_beam, 0.0, 0.0});
    first_beam = here;
  }
  EXPECT_NEAR(predictor.begin_sweep(21 * kStep, kStep).x(), kSpeed, 1e-6);
}

}  // namespace
}  // namespace slamfuse::laser_slam
