// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/floor_reckoning.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "common/pose2.hpp"
#include "visual_slam/floor_scene.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;
using Verdict = FloorReckoning::Verdict;

constexpr double kSeconds = 0.2;
constexpr common::Nanoseconds kFrame = 200'000'000;
constexpr double kWay = 0.1;  // the robot's, from image to image
constexpr double kSpeed = kWay / kSeconds;

MotionOptions in_metres() {
  MotionOptions options;
  options.model = MotionModelKind::kConstantVelocity;
  options.constant_velocity.lever_scale_sigma = 0.0;
  return options;
}

/// A robot that drives over a floor, turning so far from image to image.
class Drive {
 public:
  explicit Drive(const FloorSpeedOptions& options = {}, double turn = 0.0) : floor(options, 1), turn_(turn) {}

  /// On to the next image, and what the floor in it says.
  Verdict look() { return read(scene_.picture(camera_, next())); }
  Verdict look_at_bare_floor() {
    next();
    return read(cv::Mat(480, 640, CV_8U, cv::Scalar(128)));
  }
  Verdict look_into_the_dark() {
    next();
    return read({});
  }
  void stand_by() {
    next();
    floor.skip(filter, kSeconds);
  }

  /// A map in metres, of which the filter then learns elsewhere that the robot drives at another speed.
  void begin(double another_speed) {
    for (int i = 0; i < 3; ++i) look();
    learn(another_speed);
  }
  void learn(double another_speed) {
    filter.doubt_speed(1.0);
    certain_speed = another_speed;
  }

  double speed() const { return filter.twist()->linear.x(); }
  bool tells_metres() const { return floor.tells_metres(stamp); }

  Ekf filter{{}, in_metres()};
  FloorReckoning floor;
  common::Nanoseconds stamp = 1'700'000'000'000'000'000;
  std::optional<double> certain_speed;  ///< that the filter has learnt elsewhere

 private:
  /// The filter knows how far the robot turns, from elsewhere.
  Pose2 next() {
    robot_ = robot_ * common::exp_se2({kWay, 0.0, turn_});
    stamp += kFrame;
    filter.predict({kSeconds, {}});
    filter.correct_pose({filter.pose().x, filter.pose().y, robot_.theta}, Eigen::Vector3d(1.0, 1.0, 1e-8).asDiagonal());
    for (int i = 0; certain_speed && i < 20; ++i) filter.correct_speed(*certain_speed, 1e-4);
    return robot_;
  }

  Verdict read(const cv::Mat& picture) {
    return floor.read(filter, {.camera_index = 0,
                               .camera = camera_,
                               .picture = picture,
                               .stamp = stamp,
                               .seconds = kSeconds,
                               .landmarks = {},
                               .landmarks_spoke = false,
                               .followed = {}});
  }

  Camera camera_ = testing::make_camera("cam0", 0.0);
  testing::FloorScene scene_;
  double turn_;
  Pose2 robot_;
};

std::vector<Verdict> look(Drive& drive, int images) {
  std::vector<Verdict> verdicts;
  for (int i = 0; i < images; ++i) verdicts.push_back(drive.look());
  return verdicts;
}

FloorSpeedOptions with_patience_of_a_second() {
  FloorSpeedOptions options;
  options.patience = 1.0;
  return options;
}

TEST(FloorReckoning, TheFirstPictureSaysNothing) {
  Drive drive;
  EXPECT_FALSE(drive.tells_metres());
  EXPECT_EQ(drive.look(), Verdict::kSilent) << "there is nothing to compare it with";
  EXPECT_FALSE(drive.tells_metres());
  EXPECT_NEAR(drive.speed(), 0.0, 1e-6);
}

TEST(FloorReckoning, AReadingCorrectsTheSpeedAndTellsMetresForAWhile) {
  FloorSpeedOptions options;
  options.memory = 2.0;
  Drive drive(options);
  EXPECT_EQ(look(drive, 2), (std::vector{Verdict::kSilent, Verdict::kBelieved}));
  EXPECT_NEAR(drive.speed(), kSpeed, 0.02);
  EXPECT_TRUE(drive.floor.tells_metres(drive.stamp));
  EXPECT_TRUE(drive.floor.tells_metres(drive.stamp + common::from_seconds(1.99)));
  EXPECT_FALSE(drive.floor.tells_metres(drive.stamp + common::from_seconds(2.01)));
}

TEST(FloorReckoning, ReadsInTurnsTheFilterKnows) {
  Drive drive({}, 0.1);
  look(drive, 3);
  EXPECT_NEAR(drive.speed(), kSpeed, 0.02);
}

TEST(FloorReckoning, AFilterThatKnowsBetterRefuses) {
  Drive drive;
  drive.begin(0.1);
  EXPECT_EQ(look(drive, 3), (std::vector{Verdict::kRefused, Verdict::kRefused, Verdict::kRefused}));
  EXPECT_NEAR(drive.speed(), 0.1, 0.001);
}

TEST(FloorReckoning, AtTheBeginningTheMapsUnitIsAGuess) {
  Drive drive;
  drive.certain_speed = 0.1;
  EXPECT_EQ(look(drive, 3), (std::vector{Verdict::kSilent, Verdict::kRefused, Verdict::kWrongGuess}));
  EXPECT_NEAR(drive.speed(), kSpeed, 0.03);
  EXPECT_TRUE(drive.tells_metres());
}

TEST(FloorReckoning, NothingBeginsInTheDark) {
  Drive drive(with_patience_of_a_second());
  drive.certain_speed = 0.1;
  for (int i = 0; i < 6; ++i) EXPECT_EQ(drive.look_into_the_dark(), Verdict::kSilent);
  EXPECT_EQ(look(drive, 3).back(), Verdict::kWrongGuess);
}

TEST(FloorReckoning, AMapThatHasGrownWithoutMetresIsNotGivenUpAtOnce) {
  Drive drive(with_patience_of_a_second());
  drive.certain_speed = 0.1;
  for (int i = 0; i < 6; ++i) EXPECT_EQ(drive.look_at_bare_floor(), Verdict::kSilent);
  EXPECT_EQ(look(drive, 3), (std::vector{Verdict::kSilent, Verdict::kRefused, Verdict::kRefused}));
  EXPECT_FALSE(drive.tells_metres());
}

// Six readings a fifth of a second apart, with a patience of 1 s.
const std::vector kContradictedInTheEnd{Verdict::kRefused, Verdict::kRefused, Verdict::kRefused,
                                        Verdict::kRefused, Verdict::kRefused, Verdict::kContradicted};

TEST(FloorReckoning, AfterSteadyRefusalsTheFloorIsBelieved) {
  Drive drive(with_patience_of_a_second());
  drive.begin(0.1);
  EXPECT_EQ(look(drive, 6), kContradictedInTheEnd);
  EXPECT_NEAR(drive.speed(), kSpeed, 0.03);
  EXPECT_TRUE(drive.tells_metres());
}

TEST(FloorReckoning, RefusalsWithALongGapBetweenDoNotAddUp) {
  Drive drive(with_patience_of_a_second());
  drive.begin(0.1);
  EXPECT_EQ(look(drive, 3).back(), Verdict::kRefused);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(drive.look_into_the_dark(), Verdict::kSilent);
  EXPECT_EQ(drive.look(), Verdict::kSilent);
  EXPECT_EQ(look(drive, 6), kContradictedInTheEnd) << "patience begins anew";
}

TEST(FloorReckoning, RefusalsDoNotAddUpOverAReadingThatWasBelieved) {
  Drive drive(with_patience_of_a_second());
  drive.begin(0.1);
  EXPECT_EQ(look(drive, 5).back(), Verdict::kRefused);
  drive.certain_speed.reset();
  drive.filter.doubt_speed(1.0);
  EXPECT_EQ(drive.look(), Verdict::kBelieved);
  drive.learn(0.1);
  EXPECT_EQ(look(drive, 3), (std::vector{Verdict::kRefused, Verdict::kRefused, Verdict::kRefused}));
}

// The turn of every step counts, seen or not: without it no floor would be found again.
TEST(FloorReckoning, AStepWithoutAPictureCounts) {
  for (const bool dark : {true, false}) {
    Drive drive({}, 0.1);
    drive.look();
    if (dark) {
      EXPECT_EQ(drive.look_into_the_dark(), Verdict::kSilent);
    } else {
      drive.stand_by();
    }
    EXPECT_FALSE(drive.tells_metres());
    EXPECT_EQ(drive.look(), Verdict::kBelieved) << dark;
    EXPECT_NEAR(drive.speed(), kSpeed, 0.02) << dark;
  }
}

}  // namespace
}  // namespace slamfuse::visual_slam
