// SPDX-License-Identifier: BSD-3-Clause
#include "service/external_poses.hpp"

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

}  // namespace
}  // namespace slamfuse::service
