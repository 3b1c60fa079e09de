// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/sensor_offsets.hpp"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fusion/alignment.hpp"
#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

constexpr common::Nanoseconds kMaxGap = common::kNanosecondsPerSecond / 2;

struct Between {
  double clock_offset = 0.0;  ///< to be added to visual stamps [s]
  Eigen::Vector2d lever_arm = Eigen::Vector2d::Zero();
  double yaw = 0.0;
};

/// A path that turns both ways, and the visual's trajectory of a point beside it, in its own frame, scale and clock.
struct Drive {
  common::Trajectory2 laser;
  common::Trajectory2 visual;
};

Drive make_drive(const Between& between, double position_noise, double heading_noise, std::uint64_t seed) {
  TestNoise noise(seed);
  const PlanarAffine map = stretched_map(70.0, 0.5, 0.5, 2.0, -1.0);
  const double rotation = take_apart(map).rotation;
  Drive drive;
  const auto path = flat_path(900);
  for (const auto& pose : path) {
    const auto noisy = [&](common::Pose2 p) {
      p.x += position_noise * noise.normal();
      p.y += position_noise * noise.normal();
      p.theta = common::Pose2{0, 0, p.theta + heading_noise * noise.normal()}.theta;
      return p;
    };
    drive.laser.push_back({pose.stamp, noisy(pose.pose)});
    const common::Pose2 seen =
        noisy(pose.pose * common::Pose2{between.lever_arm.x(), between.lever_arm.y(), between.yaw});
    const Eigen::Vector2d position = map.inverse() * seen.translation();
    drive.visual.push_back(
        {pose.stamp - common::from_seconds(between.clock_offset), {position.x(), position.y(), seen.theta - rotation}});
  }
  return drive;
}

TEST(SensorOffsets, FindsClockOffsetLeverArmAndYaw) {
  for (const double clock : {-0.4, -0.05, 0.0, 0.2}) {
    const Between truth{clock, {0.25, -0.12}, 0.4};
    const Drive drive = make_drive(truth, 0.01, 0.01, 3);

    const auto found = estimate_sensor_offsets(drive.laser, drive.visual, kMaxGap, {});

    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->clock_offset, clock, 0.01);
    EXPECT_NEAR(found->lever_arm.x(), 0.25, 0.01);
    EXPECT_NEAR(found->lever_arm.y(), -0.12, 0.01);
    EXPECT_NEAR(found->yaw, 0.4, 0.01);
    EXPECT_NEAR(found->rmse, 0.01 * std::sqrt(4.0), 0.005);
  }
}

/// The truth must be within two standard deviations in about 95 % of the runs.
TEST(SensorOffsets, TheirStandardDeviationsAreThoseOfTheirErrors) {
  constexpr int kRuns = 150;
  const Between truth{0.1, {0.2, 0.1}, -0.3};
  int clock = 0;
  int lever = 0;
  int yaw = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Drive drive = make_drive(truth, 0.02, 0.02, 100 + run);
    const auto found = estimate_sensor_offsets(drive.laser, drive.visual, kMaxGap, {});
    ASSERT_TRUE(found.has_value());
    clock += std::abs(found->clock_offset - truth.clock_offset) < 1.96 * found->clock_sigma ? 1 : 0;
    lever += std::abs(found->lever_arm.x() - truth.lever_arm.x()) < 1.96 * found->lever_sigma.x() ? 1 : 0;
    yaw += std::abs(found->yaw - truth.yaw) < 1.96 * found->yaw_sigma ? 1 : 0;
  }

  for (const int inside : {clock, lever, yaw}) {
    EXPECT_GE(inside, static_cast<int>(0.89 * kRuns));
    EXPECT_LE(inside, kRuns);
  }
}

TEST(SensorOffsets, OutliersAndAStepOfTheMapDoNotMatter) {
  Drive drive = make_drive({0.15, {0.2, 0.0}, 0.0}, 0.01, 0.01, 5);
  TestNoise noise(9);
  for (auto& pose : drive.visual) {
    if (noise.uniform() < 0.1) pose.pose = {20.0 * noise.uniform(), 20.0 * noise.uniform(), 6.0 * noise.uniform()};
  }

  const auto found = estimate_sensor_offsets(drive.laser, drive.visual, kMaxGap, {});

  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->clock_offset, 0.15, 0.015);
  EXPECT_NEAR(found->lever_arm.x(), 0.2, 0.02);
}

TEST(SensorOffsets, OnlyWhatIsClearIsUsed) {
  const Drive drive = make_drive({0.2, Eigen::Vector2d::Zero(), 0.0}, 0.02, 0.02, 6);
  const auto found = estimate_sensor_offsets(drive.laser, drive.visual, kMaxGap, {});
  ASSERT_TRUE(found.has_value());

  const auto used = significant(*found, {});

  ASSERT_TRUE(used.has_value());
  EXPECT_NEAR(used->clock_offset, 0.2, 0.01);
  EXPECT_EQ(used->lever_arm, Eigen::Vector2d::Zero());
  const Drive none = make_drive({}, 0.02, 0.02, 7);
  EXPECT_FALSE(significant(*estimate_sensor_offsets(none.laser, none.visual, kMaxGap, {}), {}).has_value());
}

TEST(SensorOffsets, TooLittleInCommonIsNothing) {
  const Drive drive = make_drive({}, 0.01, 0.01, 8);
  const common::Trajectory2 few(drive.visual.begin(), drive.visual.begin() + 10);
  EXPECT_FALSE(estimate_sensor_offsets(drive.laser, few, kMaxGap, {}).has_value());
  EXPECT_FALSE(estimate_sensor_offsets({}, {}, kMaxGap, {}).has_value());
}

TEST(SensorOffsets, TheAlignmentUsesThemBothWays) {
  const Between truth{0.2, {0.3, -0.2}, 0.5};
  const Drive drive = make_drive(truth, 0.005, 0.005, 10);

  const Alignment alignment = align_trajectories(drive.laser, drive.visual, {});

  ASSERT_TRUE(alignment.accepted) << alignment.reason;
  EXPECT_NEAR(alignment.clock_offset, 0.2, 0.01);
  EXPECT_LT((alignment.lever_arm - truth.lever_arm).norm(), 0.02);
  EXPECT_LT(alignment.rmse, 0.015);
  const auto aligned = to_laser_frame(drive.visual, alignment);
  for (std::size_t i = 50; i < 850; i += 50) {
    const auto laser = common::pose_at(drive.laser, aligned[i].stamp, kMaxGap);
    ASSERT_TRUE(laser.has_value());
    EXPECT_LT((aligned[i].pose.translation() - laser->translation()).norm(), 0.05);
    const common::Pose2 back = alignment.to_visual(aligned[i].pose);
    EXPECT_LT((back.translation() - drive.visual[i].pose.translation()).norm(), 1e-9);
  }
  AlignmentOptions without;
  without.offsets.estimate = false;
  EXPECT_GT(align_trajectories(drive.laser, drive.visual, without).rmse, 5.0 * alignment.rmse);
}

}  // namespace
}  // namespace slamfuse::fusion
