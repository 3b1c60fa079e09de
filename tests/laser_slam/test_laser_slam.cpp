// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/laser_slam.hpp"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "laser_slam/map_state.hpp"
#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

using ::testing::HasSubstr;
constexpr common::Nanoseconds kPeriod = common::kNanosecondsPerSecond / 10;

struct Drive {
  std::vector<common::PoseEstimate> estimates;
  std::vector<common::Pose2> truth;
  std::vector<common::Event> events;
  std::unique_ptr<LaserSlam> slam;

  bool has_event(const std::string& kind) const {
    return std::any_of(events.begin(), events.end(), [&](const auto& event) { return event.kind == kind; });
  }
  double worst_error() const {
    double worst = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      worst = std::max(worst, testing::distance(truth.front() * estimates[i].pose, truth[i]));
    }
    return worst;
  }
};

struct DriveSettings {
  testing::Walls walls = testing::room();
  common::LaserCalibration laser = testing::full_circle_laser();
  LaserSlamOptions options;
  int threads = 1;
  bool odometry = true;
  /// Falsifies the odometry pose of a step.
  std::function<common::Pose2(int, const common::Pose2&)> odometry_error = [](int, const common::Pose2& pose) {
    return pose;
  };
};

LaserSlamOptions few_particles(int particles = 8) {
  LaserSlamOptions options;
  options.particles = particles;
  return options;
}

/// Drives through the poses, one scan each 0.1 s, with 1 cm of range noise.
Drive drive(const std::vector<common::Pose2>& poses, const DriveSettings& settings) {
  Drive result;
  result.slam = *LaserSlam::create(settings.options, "laser0", settings.laser, 1, settings.threads);
  RandomStream noise(99, 0);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const common::Nanoseconds stamp = static_cast<common::Nanoseconds>(i) * kPeriod;
    if (settings.odometry) {
      const common::Pose2 odometry = settings.odometry_error(static_cast<int>(i), poses.front().inverse() * poses[i]);
      result.slam->process(common::WheelOdometry{stamp, "odom0", odometry, 0.0, 0.0});
    }
    const common::ProcessResult processed =
        result.slam->process(testing::scan_at(settings.walls, settings.laser, stamp, poses[i], &noise));
    EXPECT_TRUE(processed.estimate) << processed.rejected.value_or("");
    if (!processed.estimate) continue;
    EXPECT_EQ(processed.estimate->stamp, stamp);
    result.estimates.push_back(*processed.estimate);
    result.truth.push_back(poses[i]);
    for (const common::Event& event : processed.estimate->events) result.events.push_back(event);
  }
  return result;
}

/// A circle of 0.8 m around (0.9, 0.5), 0.05 m a step.
std::vector<common::Pose2> circle(int steps) {
  std::vector<common::Pose2> poses;
  for (int i = 0; i < steps; ++i) {
    const double angle = 0.05 / 0.8 * i;
    poses.push_back({0.9 + 0.8 * std::cos(angle), 0.5 + 0.8 * std::sin(angle),
                     common::normalize_angle(angle + std::numbers::pi / 2.0)});
  }
  return poses;
}

/// Once round the ring and a bit further, 0.08 m a step.
std::vector<common::Pose2> round_the_ring() {
  std::vector<common::Pose2> poses;
  common::Pose2 pose{0.0, 0.0, 0.0};
  for (int side = 0; side < 5; ++side) {
    for (int i = 0; i < (side == 4 ? 50 : 150); ++i) poses.push_back(pose = pose * common::Pose2{0.08, 0.0, 0.0});
    for (int i = 0; side < 4 && i < 10; ++i) {
      poses.push_back(pose = pose * common::Pose2{0.0, 0.0, std::numbers::pi / 20.0});
    }
  }
  return poses;
}

/// What comes of one scan of the room.
std::optional<common::PoseEstimate> look(LaserSlam& slam, int step, const common::Pose2& at) {
  return slam.process(testing::scan_at(testing::room(), testing::full_circle_laser(), step * kPeriod, at)).estimate;
}

TEST(LaserSlam, FollowsADriveThroughARoom) {
  DriveSettings settings;
  settings.options = few_particles();
  settings.odometry_error = [](int, const common::Pose2& pose) {
    return common::Pose2{1.1 * pose.x, 1.1 * pose.y, common::normalize_angle(pose.theta * 1.05)};
  };
  const Drive result = drive(circle(150), settings);
  EXPECT_LT(result.worst_error(), 0.05);
  EXPECT_EQ(result.slam->final_trajectory().size(), result.estimates.size());
  for (const auto& estimate : result.estimates) {
    EXPECT_EQ(estimate.state, common::TrackingState::kTracking);
    EXPECT_EQ(estimate.source, common::PoseSource::kLaser);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(estimate.covariance).eigenvalues()(0), 0.0);
  }
  EXPECT_GT(result.estimates.back().health.scan_likelihood.value_or(0.0), 0.7);
  EXPECT_FALSE(result.estimates.back().health.degenerate_direction);
}

TEST(LaserSlam, WorksWithoutOdometry) {
  DriveSettings settings;
  settings.options = few_particles();
  settings.odometry = false;
  EXPECT_LT(drive(circle(150), settings).worst_error(), 0.05);
}

TEST(LaserSlam, SurvivesJumpsOfTheOdometry) {
  DriveSettings settings;
  settings.options = few_particles();
  settings.odometry_error = [](int i, const common::Pose2& pose) {
    common::Pose2 jumped = pose;
    if (i >= 40) jumped = common::Pose2{5.0, -3.0, 1.0} * jumped;  // a teleport
    if (i >= 80) jumped = common::Pose2{0.25, 0.1, 0.3} * jumped;  // a wheel slipped: possible but wrong
    return jumped;
  };
  EXPECT_LT(drive(circle(130), settings).worst_error(), 0.08);
}

TEST(LaserSlam, SeesThroughOdometryThatCountsForwardWhileTheRobotBacksUp) {
  std::vector<common::Pose2> poses;
  for (int i = 0; i < 20; ++i) poses.push_back({0.08 * i, 0.0, 0.0});
  for (int i = 0; i < 5; ++i) poses.push_back(poses.back());
  for (int i = 1; i < 20; ++i) poses.push_back({1.52 - 0.08 * i, 0.0, 0.0});
  DriveSettings settings;
  settings.options = few_particles();
  settings.odometry_error = [](int i, const common::Pose2&) {
    return common::Pose2{0.08 * (i < 20 ? i : std::max(19, i - 5)), 0.0, 0.0};
  };
  EXPECT_LT(drive(poses, settings).worst_error(), 0.1);
}

TEST(LaserSlam, TakesALaserMountedUpsideDownAndAside) {
  DriveSettings settings;
  settings.options = few_particles();
  settings.laser.T_base_laser.translation = {0.2, -0.1, 0.4};
  settings.laser.T_base_laser.rotation =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
  EXPECT_LT(drive(circle(100), settings).worst_error(), 0.05);
}

TEST(LaserSlam, GivesTheSameBitsWithOneTwoAndThreeThreads) {
  DriveSettings settings;
  settings.options = few_particles();
  const Drive one = drive(circle(60), settings);
  for (const int threads : {2, 3}) {
    settings.threads = threads;
    const Drive many = drive(circle(60), settings);
    for (std::size_t i = 0; i < one.estimates.size(); ++i) {
      ASSERT_EQ(one.estimates[i].pose.vector(), many.estimates[i].pose.vector());
      ASSERT_EQ(one.estimates[i].covariance, many.estimates[i].covariance);
    }
    EXPECT_EQ(one.slam->grid().cells, many.slam->grid().cells);
    EXPECT_EQ(*one.slam->serialize(), *many.slam->serialize());
  }
}

TEST(LaserSlam, ClosesALoopAndSaysSo) {
  DriveSettings settings;
  settings.walls = testing::ring();
  settings.options = few_particles(15);
  settings.odometry_error = [](int, const common::Pose2& pose) {
    return common::Pose2{1.03 * pose.x, 1.03 * pose.y, pose.theta};
  };
  const Drive result = drive(round_the_ring(), settings);
  EXPECT_LT(result.worst_error(), 0.25);
  EXPECT_TRUE(result.has_event("loop_closed"));
  const auto end = result.slam->final_trajectory().back().pose;
  EXPECT_LT(testing::distance(result.truth.front() * end, result.truth.back()), 0.12);
}

TEST(LaserSlam, RejectsImpossibleScansAndGoesOn) {
  Drive result = drive(circle(20), {.options = few_particles()});
  common::LaserScan bad = testing::scan_at(testing::room(), testing::full_circle_laser(), 20 * kPeriod, circle(21)[20]);
  bad.ranges[3] = -1.0f;
  EXPECT_THAT(result.slam->process(bad).rejected.value_or(""), HasSubstr("range -1 of beam 3"));
  bad.ranges.resize(10);
  EXPECT_THAT(result.slam->process(bad).rejected.value_or(""), HasSubstr("10 ranges, allowed are 180"));
  const common::WheelOdometry bad_odometry{
      20 * kPeriod, "odom0", {std::numeric_limits<double>::infinity(), 0.0, 0.0}, 0.0, 0.0};
  EXPECT_THAT(result.slam->process(bad_odometry).rejected.value_or(""), HasSubstr("not finite"));
  EXPECT_EQ(result.slam->final_trajectory().size(), 20u);

  const auto good = testing::scan_at(testing::room(), testing::full_circle_laser(), 20 * kPeriod, circle(21)[20]);
  const auto estimate = result.slam->process(good).estimate;
  ASSERT_TRUE(estimate);
  EXPECT_LT(testing::distance(result.truth.front() * estimate->pose, circle(21)[20]), 0.05);
}

TEST(LaserSlam, RejectsScansWithoutAnyMeasurementAndStandsByItsPose) {
  Drive result = drive(circle(20), {.options = few_particles()});
  common::LaserScan blind;
  blind.sensor = "laser0";
  blind.ranges.assign(180, std::numeric_limits<float>::quiet_NaN());
  for (int i = 20; i < 25; ++i) {
    blind.stamp = i * kPeriod;
    const auto processed = result.slam->process(blind);
    EXPECT_FALSE(processed.estimate);
    EXPECT_THAT(processed.rejected.value_or(""), HasSubstr("no usable beam"));
  }
  blind.ranges[90] = 2.0F;  // one beam that measures something is a scan
  EXPECT_TRUE(result.slam->process(blind).estimate);
  EXPECT_EQ(result.slam->final_trajectory().size(), 21u);
}

TEST(LaserSlam, BeginsItsMapWithTheFirstScanThatSawSomething) {
  auto slam = *LaserSlam::create(few_particles(), "laser0", testing::full_circle_laser(), 1, 1);
  common::LaserScan warming_up;
  warming_up.sensor = "laser0";
  warming_up.ranges.assign(180, HUGE_VALF);
  EXPECT_THAT(slam->process(warming_up).rejected.value_or(""), HasSubstr("no beam met anything"));
  const auto poses = circle(60);
  for (int i = 0; i < 60; ++i) {
    const common::Pose2& pose = poses[static_cast<std::size_t>(i)];
    slam->process(common::WheelOdometry{i * kPeriod, "odom0", poses.front().inverse() * pose, 0.0, 0.0});
    const auto estimate = look(*slam, i, pose);
    ASSERT_TRUE(estimate);
    EXPECT_LT(testing::distance(poses.front() * estimate->pose, pose), 0.05) << "step " << i;
  }
}

TEST(LaserSlam, WorksWithAnyFieldOfViewAndNumberOfBeams) {
  const std::vector<std::pair<double, int>> lasers = {{90.0, 45}, {180.0, 361}, {270.0, 10000}};  // [deg], beams
  for (const auto& [degrees, beams] : lasers) {
    DriveSettings settings;
    settings.options = few_particles();
    settings.laser = testing::full_circle_laser(beams);
    settings.laser.angle_min = -common::to_radians(degrees / 2.0);
    settings.laser.angle_increment = common::to_radians(degrees) / (beams - 1);
    EXPECT_LT(drive(circle(40), settings).worst_error(), 0.15) << beams << " beams over " << degrees << " deg";
  }
}

TEST(LaserSlam, StaysWithGoodOdometryWhenItsLaserIsSparse) {
  for (const int beams : {16, 32, 45, 64, 90}) {
    DriveSettings settings;
    settings.options = few_particles();
    settings.laser = testing::full_circle_laser(beams);
    EXPECT_LT(drive(circle(60), settings).worst_error(), 0.15) << beams << " beams";
  }
}

TEST(LaserSlam, GivesAPoseForEveryScanOfTwoBeams) {
  DriveSettings settings;
  settings.options = few_particles();
  settings.laser = testing::full_circle_laser(2);
  const Drive result = drive(circle(60), settings);
  ASSERT_EQ(result.estimates.size(), 60u);
  for (const auto& estimate : result.estimates) {
    EXPECT_TRUE(estimate.pose.is_finite() && estimate.covariance.allFinite());
    EXPECT_FALSE(estimate.health.scan_likelihood) << "two beams agree with anything";
  }
}

TEST(LaserSlam, TakesNumbersOfBeamsThatChange) {
  common::LaserCalibration laser = testing::full_circle_laser();
  laser.beams = 0;
  auto slam = *LaserSlam::create(few_particles(), "laser0", laser, 1, 1);
  const auto poses = circle(60);
  for (int i = 0; i < 60; ++i) {
    const common::Pose2& pose = poses[static_cast<std::size_t>(i)];
    slam->process(common::WheelOdometry{i * kPeriod, "odom0", poses.front().inverse() * pose, 0.0, 0.0});
    common::LaserScan scan = testing::scan_at(testing::room(), testing::full_circle_laser(), i * kPeriod, pose);
    scan.ranges.resize(i % 3 == 0 ? 180 : 100 + static_cast<std::size_t>(i));  // the last beams are missing
    const auto estimate = slam->process(scan).estimate;
    ASSERT_TRUE(estimate);
    EXPECT_LT(testing::distance(poses.front() * estimate->pose, pose), 0.08) << "step " << i;
  }
}

TEST(LaserSlam, IgnoresOtherSensors) {
  Drive result = drive(circle(2), {.options = few_particles()});
  common::LaserScan other = testing::scan_at(testing::room(), testing::full_circle_laser(), kPeriod, common::Pose2{});
  other.sensor = "laser1";
  EXPECT_FALSE(result.slam->wants(other));
  EXPECT_TRUE(result.slam->wants(common::WheelOdometry{}));
  EXPECT_FALSE(result.slam->wants(common::Image{}));
  const auto processed = result.slam->process(other);
  EXPECT_FALSE(processed.estimate || processed.rejected);
}

TEST(LaserSlam, StartsANewEpochOnReset) {
  Drive result = drive(circle(30), {.options = few_particles()});
  result.slam->execute(common::Reset{});
  EXPECT_TRUE(result.slam->final_trajectory().empty());
  EXPECT_EQ(result.slam->grid().width, 0);
  EXPECT_FALSE(result.slam->serialize());
  const auto estimate =
      result.slam
          ->process(testing::scan_at(testing::room(), testing::full_circle_laser(), 31 * kPeriod, common::Pose2{}))
          .estimate;
  ASSERT_TRUE(estimate);
  EXPECT_EQ(estimate->map_epoch, 1u);
  EXPECT_EQ(estimate->pose.vector(), Eigen::Vector3d::Zero());
  ASSERT_EQ(estimate->events.size(), 1u);
  EXPECT_EQ(estimate->events[0].kind, "map_reset");
}

TEST(LaserSlam, MovesToAPoseSetFromOutside) {
  Drive result = drive(circle(40), {.options = few_particles()});
  const common::Pose2 there = result.truth.front().inverse() * common::Pose2{0.5, 0.5, 0.3};
  result.slam->execute(common::SetPose{there, Eigen::Vector3d(0.0025, 0.0025, 0.0025).asDiagonal()});
  // The robot was carried there and stands; the wheels have not turned.
  const auto scan =
      testing::scan_at(testing::room(), testing::full_circle_laser(), 40 * kPeriod, common::Pose2{0.5, 0.5, 0.3});
  const auto estimate = result.slam->process(scan).estimate;
  ASSERT_TRUE(estimate);
  EXPECT_LT(testing::distance(estimate->pose, there), 0.03);
  EXPECT_EQ(result.slam->final_trajectory().size(), 41u);
}

TEST(LaserSlam, AnswersRelocaliseWithAnEvent) {
  Drive result = drive(circle(5), {.options = few_particles()});
  result.slam->execute(common::Relocalise{});
  const auto scan = testing::scan_at(testing::room(), testing::full_circle_laser(), 5 * kPeriod, circle(6)[5]);
  const auto estimate = result.slam->process(scan).estimate;
  ASSERT_TRUE(estimate);
  ASSERT_FALSE(estimate->events.empty());
  EXPECT_EQ(estimate->events[0].kind, "relocalise_refused");
}

TEST(LaserSlam, StartsInASavedMapWhereItIsTold) {
  const Drive first = drive(circle(50), {.options = few_particles()});
  const auto bytes = first.slam->serialize();
  ASSERT_TRUE(bytes);
  const common::Pose2 there{0.4, 0.9, 0.5};
  auto second = *LaserSlam::create(few_particles(), "laser0", testing::full_circle_laser(), 2, 1);
  ASSERT_TRUE(second->restore(*bytes));
  const common::Pose2 in_map = circle(1).front().inverse() * there;
  second->execute(common::SetPose{in_map, Eigen::Vector3d(0.0025, 0.0025, 0.0025).asDiagonal()});
  common::PoseEstimate last;
  for (int i = 0; i < 5; ++i) last = look(*second, i, there).value_or(last);
  EXPECT_LT(testing::distance(last.pose, in_map), 0.05);
  EXPECT_EQ(last.state, common::TrackingState::kTracking);
}

// A service that is stopped before the first scan must not write an empty map over the one it was given.
TEST(LaserSlam, SavesWhatItLoadedUntilTheFirstScan) {
  const Drive first = drive(circle(50), {.options = few_particles()});
  const auto bytes = first.slam->serialize();
  ASSERT_TRUE(bytes);
  auto second = *LaserSlam::create(few_particles(), "laser0", testing::full_circle_laser(), 2, 1);
  ASSERT_TRUE(second->restore(*bytes));
  EXPECT_EQ(second->serialize().value(), *bytes);
}

TEST(LaserSlam, ForgetsASavedMapOnResetBeforeTheFirstScan) {
  const Drive first = drive(circle(50), {.options = few_particles()});
  auto second = *LaserSlam::create(few_particles(), "laser0", testing::full_circle_laser(), 2, 1);
  ASSERT_TRUE(second->restore(*first.slam->serialize()));
  second->execute(common::Reset{});
  const auto estimate = look(*second, 0, {});
  ASSERT_TRUE(estimate);
  EXPECT_EQ(estimate->pose.vector(), Eigen::Vector3d::Zero());
  const auto state = parse_state(*second->serialize(), few_particles().map);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->path_length, 0.0) << "a new map has been driven in by nobody";
}

TEST(LaserSlam, AnswersAPoseItCannotTakeWithAnEvent) {
  const common::Pose2 good{0.1, 0.0, 0.0};
  Eigen::Matrix3d indefinite = Eigen::Matrix3d::Identity() * 0.01;
  indefinite(0, 1) = indefinite(1, 0) = 1.0;
  const std::vector<common::SetPose> bad = {
      {{std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}, Eigen::Matrix3d::Identity() * 0.01},
      {{1e9, 0.0, 0.0}, Eigen::Matrix3d::Identity() * 0.01},
      {{0.0, 0.0, std::numeric_limits<double>::infinity()}, Eigen::Matrix3d::Identity() * 0.01},
      {good, Eigen::Matrix3d::Constant(std::numeric_limits<double>::infinity())},
      {good, Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN())},
      {good, Eigen::Matrix3d::Identity() * 1e12},
      {good, Eigen::Matrix3d::Identity() * -1.0},
      {good, indefinite}};
  for (const common::SetPose& command : bad) {
    Drive result = drive(circle(10), {.options = few_particles()});
    result.slam->execute(command);
    const auto estimate = look(*result.slam, 10, circle(11)[10]);
    ASSERT_TRUE(estimate);
    ASSERT_EQ(estimate->events.size(), 1u);
    EXPECT_EQ(estimate->events[0].kind, "set_pose_refused");
    EXPECT_LT(testing::distance(result.truth.front() * estimate->pose, circle(11)[10]), 0.05);
  }
  auto fresh = *LaserSlam::create(few_particles(), "laser0", testing::full_circle_laser(), 2, 1);
  fresh->execute(common::SetPose{good, Eigen::Matrix3d::Identity() * 0.01});
  const auto estimate = look(*fresh, 0, {});
  ASSERT_TRUE(estimate);
  ASSERT_EQ(estimate->events.size(), 1u);
  EXPECT_EQ(estimate->events[0].kind, "set_pose_refused") << "there is no map yet for the pose to be in";
}

TEST(LaserSlam, TakesAPoseThatIsHardlyKnownAndStaysWhereItFits) {
  for (const double variance : {0.0, 4.0, 1e6}) {  // [m2, rad2]
    Drive result = drive(circle(40), {.options = few_particles(30)});
    const auto poses = circle(60);
    const common::Pose2 there = result.truth.front().inverse() * poses[40];
    result.slam->execute(common::SetPose{there, Eigen::Matrix3d::Identity() * variance});
    for (std::size_t i = 40; i < 60; ++i) {
      const auto estimate = look(*result.slam, static_cast<int>(i), poses[i]);
      ASSERT_TRUE(estimate && estimate->pose.is_finite() && estimate->covariance.allFinite());
      EXPECT_LT(testing::distance(result.truth.front() * estimate->pose, poses[i]), 0.1) << variance << ", step " << i;
    }
    EXPECT_LT(result.slam->grid().cells.size(), 1u << 20) << "no particle far away draws into the best one's map";
  }
}

TEST(LaserSlam, TellsOfAPoseSetToWhereNothingIsMapped) {
  Drive result = drive(circle(20), {.options = few_particles()});
  for (const auto& [x, words] : {std::pair(0.0, "from outside"), std::pair(80.0, "nothing is mapped yet")}) {
    result.slam->execute(common::SetPose{{x, 0.0, 0.0}, Eigen::Matrix3d::Identity() * 0.01});
    const auto estimate = look(*result.slam, 20, circle(1)[0]);
    ASSERT_TRUE(estimate);
    ASSERT_FALSE(estimate->events.empty());
    EXPECT_EQ(estimate->events[0].kind, "relocalised");
    EXPECT_THAT(estimate->events[0].detail, HasSubstr(words));
    EXPECT_EQ(estimate->health.scan_likelihood.has_value(), x == 0.0) << "nothing there to agree with";
  }
}

TEST(LaserSlam, KeepsItsMapSmallWhenPutFarAway) {
  Drive result = drive(circle(10), {.options = few_particles()});
  result.slam->execute(common::SetPose{{15000.0, -15000.0, 0.0}, Eigen::Matrix3d::Identity() * 0.01});
  for (int i = 10; i < 40; ++i) ASSERT_TRUE(look(*result.slam, i, circle(40)[static_cast<std::size_t>(i)]));
  EXPECT_LT(result.slam->serialize()->size(), 50u << 20);
  EXPECT_LT(result.slam->grid().cells.size(), 50u << 20);
}

TEST(LaserSlam, RejectsOdometryThatIsImpossiblyFarAway) {
  Drive result = drive(circle(10), {.options = few_particles()});
  for (const double far : {1e300, -1e12}) {
    const common::WheelOdometry odometry{10 * kPeriod, "odom0", {0.0, far, 0.0}, 0.0, 0.0};
    EXPECT_THAT(result.slam->process(odometry).rejected.value_or(""), HasSubstr("allowed are up to"));
  }
}

TEST(LaserSlam, SurvivesATeleportOfTheOdometryInTheMiddleOfASweep) {
  DriveSettings settings;
  settings.options = few_particles();
  settings.laser.sweep_duration = 0.04;
  Drive result = drive(circle(20), settings);
  const auto poses = circle(24);
  for (int i = 20; i < 24; ++i) {
    const auto stamp = i * kPeriod;
    // The odometry is ahead of the scans, and starts anew between their first and last beam.
    result.slam->process(common::WheelOdometry{stamp - kPeriod / 100, "odom0", poses[20], 0.0, 0.0});
    result.slam->process(common::WheelOdometry{stamp + kPeriod / 10, "odom0", {9e3 * i, -9e3, 0.0}, 0.0, 0.0});
    const auto estimate = look(*result.slam, i, poses[static_cast<std::size_t>(i)]);
    ASSERT_TRUE(estimate);
    EXPECT_LT(testing::distance(result.truth.front() * estimate->pose, poses[static_cast<std::size_t>(i)]), 0.1);
  }
}

TEST(LaserSlam, DoesNotFollowATeleportOfTheOdometryIntoTheUnknown) {
  DriveSettings settings;
  settings.options = few_particles();
  Drive result = drive(circle(40), settings);
  // Half of the beams are cut short by people: the scan fits its map less well than it fits no map at all.
  RandomStream random(4, 4);
  const auto poses = circle(45);
  for (int i = 40; i < 45; ++i) {
    const auto& pose = poses[static_cast<std::size_t>(i)];
    common::LaserScan scan = testing::scan_at(testing::room(), settings.laser, i * kPeriod, pose);
    for (std::size_t beam = 0; beam < scan.ranges.size(); beam += 2) {
      scan.ranges[beam] = static_cast<float>(0.3 + 0.6 * random.uniform());
    }
    const auto odometry = common::Pose2{300.0, -500.0, 1.0} * (poses.front().inverse() * pose);
    result.slam->process(common::WheelOdometry{i * kPeriod, "odom0", odometry, 0.0, 0.0});
    const auto estimate = result.slam->process(scan).estimate;
    ASSERT_TRUE(estimate);
    EXPECT_LT(testing::distance(result.truth.front() * estimate->pose, pose), 0.1) << "step " << i;
  }
}

TEST(LaserSlam, IsNotLostWhereThereIsNothingToSee) {
  Drive result = drive(circle(10), {.options = few_particles()});
  common::LaserScan open;
  open.sensor = "laser0";
  open.ranges.assign(180, HUGE_VALF);
  for (int hits = 0; hits < 2; ++hits) {
    if (hits > 0) open.ranges[90] = 0.5F;  // a single beam that fits nowhere: no reason either
    for (int i = 0; i < 30; ++i) {
      open.stamp = (10 + 30 * hits + i) * kPeriod;
      const auto estimate = result.slam->process(open).estimate;
      ASSERT_TRUE(estimate);
      ASSERT_NE(estimate->state, common::TrackingState::kLost) << hits << " hits";
      EXPECT_FALSE(estimate->health.scan_likelihood);
    }
  }
}

TEST(LaserSlam, TellsOfADegenerateDirectionAgainAfterAReset) {
  DriveSettings settings;
  settings.options = few_particles();
  settings.walls = {{{-100.0, -1.0}, {300.0, -1.0}}, {{-100.0, 1.0}, {300.0, 1.0}}};
  settings.laser = testing::full_circle_laser(360);
  settings.laser.range_max = 2.5;
  std::vector<common::Pose2> poses;
  for (int i = 0; i < 150; ++i) poses.push_back({0.1 * i, 0.0, 0.0});
  Drive result = drive(poses, settings);
  ASSERT_TRUE(result.has_event("degenerate"));
  result.slam->execute(common::Reset{});
  bool told = false;
  for (int i = 150; i < 160; ++i) {
    const common::Pose2 pose{0.1 * i, 0.0, 0.0};
    result.slam->process(common::WheelOdometry{i * kPeriod, "odom0", pose, 0.0, 0.0});
    const auto estimate =
        result.slam->process(testing::scan_at(settings.walls, settings.laser, i * kPeriod, pose)).estimate;
    ASSERT_TRUE(estimate);
    for (const common::Event& event : estimate->events) told = told || event.kind == "degenerate";
  }
  EXPECT_TRUE(told);
}

TEST(LaserSlam, TakesStampsThatRepeatAndStepBack) {
  auto slam = *LaserSlam::create(few_particles(), "laser0", testing::full_circle_laser(), 1, 1);
  const auto poses = circle(60);
  for (int i = 0; i < 60; ++i) {
    const auto& pose = poses[static_cast<std::size_t>(i)];
    const common::Nanoseconds stamp = (i % 7 == 3 ? i - 3 : i % 7 == 5 ? i - 1 : i) * kPeriod;
    slam->process(common::WheelOdometry{stamp, "odom0", poses.front().inverse() * pose, 0.0, 0.0});
    const auto estimate =
        slam->process(testing::scan_at(testing::room(), testing::full_circle_laser(), stamp, pose)).estimate;
    ASSERT_TRUE(estimate);
    EXPECT_EQ(estimate->stamp, stamp);
    EXPECT_LT(testing::distance(poses.front() * estimate->pose, pose), 0.05) << "step " << i;
  }
}

TEST(LaserSlam, UsesOdometryThatBeginsLateAndArrivesLate) {
  auto slam = *LaserSlam::create(few_particles(), "laser0", testing::full_circle_laser(), 1, 1);
  const auto poses = circle(120);
  for (int i = 0; i < 120; ++i) {
    const auto& pose = poses[static_cast<std::size_t>(i)];
    if (i >= 30) {  // another frame than the map's, and two scans late
      const common::Pose2 odometry = common::Pose2{7.0, -4.0, 2.0} * poses[static_cast<std::size_t>(i - 2)];
      slam->process(common::WheelOdometry{(i - 2) * kPeriod, "odom0", odometry, 0.0, 0.0});
    }
    const auto estimate = look(*slam, i, pose);
    ASSERT_TRUE(estimate);
    EXPECT_LT(testing::distance(poses.front() * estimate->pose, pose), 0.05) << "step " << i;
  }
}

TEST(LaserSlam, TakesALaserThatCountsClockwiseRoundAndRepeatsItsFirstBeam) {
  DriveSettings settings;
  settings.options = few_particles();
  settings.laser.angle_min = common::to_radians(180.0);
  settings.laser.angle_increment = -common::to_radians(2.0);
  settings.laser.beams = 181;
  EXPECT_LT(drive(circle(100), settings).worst_error(), 0.05);
}

TEST(LaserSlam, ContinuesInASavedMap) {
  const auto poses = circle(100);
  const Drive first = drive({poses.begin(), poses.begin() + 50}, {.options = few_particles()});
  const auto bytes = first.slam->serialize();
  ASSERT_TRUE(bytes);

  auto second = *LaserSlam::create(few_particles(), "laser0", testing::full_circle_laser(), 2, 1);
  ASSERT_TRUE(second->restore(*bytes));
  EXPECT_FALSE(second->restore("nonsense"));
  common::PoseEstimate last;
  for (int i = 49; i < 100; ++i) {
    const auto stamp = i * kPeriod;
    second->process(common::WheelOdometry{stamp, "odom0", poses[static_cast<std::size_t>(i)], 0.0, 0.0});
    const auto processed = second->process(
        testing::scan_at(testing::room(), testing::full_circle_laser(), stamp, poses[static_cast<std::size_t>(i)]));
    ASSERT_TRUE(processed.estimate);
    last = *processed.estimate;
  }
  EXPECT_EQ(last.map_epoch, 1u);
  EXPECT_LT(testing::distance(poses.front() * last.pose, poses.back()), 0.05) << "in the frame of the first run";
}

TEST(LaserSlam, ContinuedMapIsThatOfOneRun) {
  DriveSettings settings;
  settings.walls = testing::ring();
  settings.options = few_particles(15);
  const auto poses = round_the_ring();
  const Drive whole = drive(poses, settings);
  constexpr std::size_t kHalf = 330;
  const Drive first = drive({poses.begin(), poses.begin() + kHalf}, settings);
  auto second = *LaserSlam::create(settings.options, "laser0", settings.laser, 2, 1);
  ASSERT_TRUE(second->restore(*first.slam->serialize()));
  bool closed = false;
  for (std::size_t i = kHalf - 1; i < poses.size(); ++i) {
    const auto stamp = static_cast<common::Nanoseconds>(i) * kPeriod;
    second->process(common::WheelOdometry{stamp, "odom0", poses[i], 0.0, 0.0});
    const auto estimate = second->process(testing::scan_at(settings.walls, settings.laser, stamp, poses[i])).estimate;
    ASSERT_TRUE(estimate);
    for (const common::Event& event : estimate->events) closed = closed || event.kind == "loop_closed";
  }
  EXPECT_TRUE(closed) << "with what the first run has seen";
  const auto path = second->final_trajectory();
  ASSERT_EQ(path.size(), poses.size() - kHalf + 1);
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_LT(testing::distance(poses.front() * path[i].pose, poses[kHalf - 1 + i]), 0.2) << i;
  }
  const common::OccupancyGrid grid = second->grid();
  EXPECT_NEAR(grid.width, whole.slam->grid().width, 4);
  EXPECT_NEAR(grid.height, whole.slam->grid().height, 4);
  // One set of walls: as many occupied cells as the run that mapped it in one go.
  const auto occupied = [](const common::OccupancyGrid& map) {
    return std::count_if(map.cells.begin(), map.cells.end(), [](int cell) { return cell > 65; });
  };
  EXPECT_LT(static_cast<double>(occupied(grid)), 1.15 * static_cast<double>(occupied(whole.slam->grid())));
}

TEST(LaserSlam, RefusesACalibrationItCannotUse) {
  common::LaserCalibration laser = testing::full_circle_laser();
  laser.angle_increment = 0.0;
  const auto slam = LaserSlam::create({}, "laser0", laser, 1, 1);
  ASSERT_FALSE(slam);
  EXPECT_EQ(slam.error().kind, common::ErrorKind::kInvalidInput);
  EXPECT_THAT(slam.error().message, HasSubstr("laser0"));
}

TEST(LaserSlam, RefusesAGridTooFineForItsRange) {
  LaserSlamOptions options;
  options.map.resolution = 0.01;
  options.map.mapping_range = 200.0;
  const auto slam = LaserSlam::create(options, "laser0", testing::full_circle_laser(), 1, 1);
  ASSERT_FALSE(slam);
  EXPECT_THAT(slam.error().message, HasSubstr("laser.map.mapping_range"));
}

TEST(LaserSlam, SaysItIsLostWhenTheScansMatchNothing) {
  DriveSettings settings;
  settings.options = few_particles();
  Drive result = drive(circle(60), settings);
  // Suddenly a crowd stands close around the robot: every beam is cut short at random.
  RandomStream random(4, 4);
  bool lost = false;
  for (int i = 60; i < 100; ++i) {
    common::LaserScan scan;
    scan.stamp = i * kPeriod;
    scan.sensor = "laser0";
    for (int beam = 0; beam < 180; ++beam) scan.ranges.push_back(static_cast<float>(0.3 + 0.6 * random.uniform()));
    const auto estimate = result.slam->process(scan).estimate;
    ASSERT_TRUE(estimate);
    lost = lost || estimate->state == common::TrackingState::kLost;
  }
  EXPECT_TRUE(lost);
}

}  // namespace
}  // namespace slamfuse::laser_slam
