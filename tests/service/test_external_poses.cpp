// SPDX-License-Identifier: BSD-3-Clause
#include "service/external_poses.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using common::ExternalPose;

TEST(ExternalPoses, BecomeEstimatesOfTheHalfTheyReplace) {
  ExternalPoses poses(kVisualPose, {});
  EXPECT_EQ(poses.source(), common::PoseSource::kVisual);
  EXPECT_TRUE(poses.wants(ExternalPose{1, kVisualPose, "map", {}, std::nullopt}));
  EXPECT_FALSE(poses.wants(ExternalPose{1, kLaserPose, "map", {}, std::nullopt}));
  EXPECT_FALSE(poses.wants(common::LaserScan{1, "laser0", {}}));
  const Eigen::Matrix3d covariance = 0.04 * Eigen::Matrix3d::Identity();
  const auto result = poses.process(ExternalPose{5, kVisualPose, "map", {1.0, 2.0, 0.5}, covariance});
  ASSERT_TRUE(result.estimate);
  EXPECT_EQ(result.estimate->stamp, 5);
  EXPECT_EQ(result.estimate->source, common::PoseSource::kVisual);
  EXPECT_EQ(result.estimate->pose.y, 2.0);
  EXPECT_EQ(result.estimate->covariance, covariance);
  EXPECT_EQ(poses.final_trajectory().size(), 1u);
}

TEST(ExternalPoses, HaveTheSetCovarianceWhereTheyTellNone) {
  ExternalPoseOptions options;
  options.position_sigma = 0.1;
  options.heading_sigma = 0.2;
  ExternalPoses poses(kLaserPose, options);
  const Eigen::Matrix3d expected = Eigen::Vector3d(0.01, 0.01, 0.04).asDiagonal();
  for (const auto& told : {std::optional<Eigen::Matrix3d>(), std::optional<Eigen::Matrix3d>(Eigen::Matrix3d::Zero())}) {
    const auto result = poses.process(ExternalPose{5, kLaserPose, "map", {}, told});
    EXPECT_TRUE(result.estimate->covariance.isApprox(expected));
  }
}

TEST(ExternalPoses, AnotherFrameBeginsANewEpoch) {
  ExternalPoses poses(kLaserPose, {});
  EXPECT_EQ(poses.process(ExternalPose{1, kLaserPose, "map", {}, std::nullopt}).estimate->map_epoch, 0u);
  const auto result = poses.process(ExternalPose{2, kLaserPose, "map_2", {}, std::nullopt});
  EXPECT_EQ(result.estimate->map_epoch, 1u);
  ASSERT_EQ(result.estimate->events.size(), 1u);
  EXPECT_EQ(result.estimate->events[0].kind, "map_reset");
  EXPECT_EQ(poses.final_trajectory().size(), 1u);
}

TEST(ExternalPoses, ARestartBeginsANewEpochWhereItMakesANewMap) {
  ExternalPoseOptions options;
  options.laser_restart = AfterRestart::kSameMap;
  const auto epochs_of = [&](const std::string& sensor) {
    ExternalPoses poses(sensor, options);
    std::vector<std::uint32_t> epochs;
    common::Nanoseconds stamp = 0;
    // The second publisher takes over; what the first one still sends is no third map.
    for (const std::uint64_t publisher : {7, 7, 8, 7, 8}) {
      epochs.push_back(
          poses.process(ExternalPose{++stamp, sensor, "map", {}, std::nullopt, publisher}).estimate->map_epoch);
    }
    return epochs;
  };
  EXPECT_THAT(epochs_of(kVisualPose), testing::ElementsAre(0, 0, 1, 1, 1));
  EXPECT_THAT(epochs_of(kLaserPose), testing::ElementsAre(0, 0, 0, 0, 0));
}

TEST(ExternalPoses, ARestartInTheSameMapIsToldOnce) {
  ExternalPoseOptions options;
  options.laser_restart = AfterRestart::kSameMap;
  options.restart_settle = 2.0;
  ExternalPoses poses(kLaserPose, options);
  std::vector<std::string> told;
  std::vector<bool> lost;
  common::Nanoseconds stamp = 0;
  for (const std::uint64_t publisher : {7, 8, 7, 8}) {
    stamp += common::kNanosecondsPerSecond;
    const auto result = poses.process(ExternalPose{stamp, kLaserPose, "map", {}, std::nullopt, publisher});
    for (const auto& event : result.estimate->events) told.push_back(event.module + " " + event.kind);
    lost.push_back(result.estimate->state == common::TrackingState::kLost);
  }
  EXPECT_THAT(told, testing::ElementsAre("laser restarted"));
  EXPECT_THAT(lost, testing::ElementsAre(false, true, true, false)) << "it does not know yet where it is";
  EXPECT_EQ(poses.final_trajectory().size(), 2u);
}

}  // namespace
}  // namespace slamfuse::service
