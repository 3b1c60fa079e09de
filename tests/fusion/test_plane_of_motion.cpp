// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/plane_of_motion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "common/angle.hpp"
#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

using testing::HasSubstr;

/// The path as a monocular SLAM tells it: in the frame of its first camera (z forward, y down), in its own unit.
common::Trajectory3 as_camera_path(const common::Trajectory2& path, double unit) {
  Eigen::Matrix3d base_from_optical;
  base_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  common::Pose3 T_base_camera;
  T_base_camera.rotation = Eigen::Quaterniond(base_from_optical);
  common::Trajectory3 camera;
  const common::Pose3 T_map_first = common::to_pose3(path.front().pose) * T_base_camera;
  for (const common::StampedPose2& pose : path) {
    common::Pose3 relative = T_map_first.inverse() * (common::to_pose3(pose.pose) * T_base_camera);
    relative.translation /= unit;
    camera.push_back({pose.stamp, relative});
  }
  return camera;
}

TEST(PlaneOfMotion, OfAPlanarTrajectoryIsTheXYPlaneExactly) {
  const auto plane = find_plane_of_motion(common::to_spatial(flat_path()));

  ASSERT_TRUE(plane.has_value());
  EXPECT_EQ(plane->x, Eigen::Vector3d::UnitX());
  EXPECT_EQ(plane->normal, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(plane->heading_axis, 0);
}

TEST(PlaneOfMotion, OfAForwardLookingCameraHasUpAgainstItsYAxis) {
  const auto plane = find_plane_of_motion(as_camera_path(flat_path(), 1.0));

  ASSERT_TRUE(plane.has_value());
  EXPECT_NEAR(plane->normal.y(), -1.0, 1e-9);
  EXPECT_EQ(plane->heading_axis, 2);
  EXPECT_LT(plane->flatness, 1e-9);
}

TEST(PlaneOfMotion, KeepsDistancesAndTurningSense) {
  const auto path = flat_path(200);
  const auto camera = as_camera_path(path, 1.0);

  const auto planar = project(camera, *find_plane_of_motion(camera));

  for (std::size_t i = 10; i < path.size(); i += 10) {
    EXPECT_NEAR((planar[i].pose.translation() - planar[i - 10].pose.translation()).norm(),
                (path[i].pose.translation() - path[i - 10].pose.translation()).norm(), 1e-9);
    EXPECT_NEAR(common::angle_difference(planar[i].pose.theta, planar[i - 10].pose.theta),
                common::angle_difference(path[i].pose.theta, path[i - 10].pose.theta), 1e-9);
  }
}

TEST(AlignSpatial, AlignsAMonocularCameraPathWithThePlanarLaserPath) {
  const auto path = flat_path();
  const auto camera = as_camera_path(path, 0.2);

  const SpatialAlignment result = align_spatial(common::to_spatial(path), camera, {});

  ASSERT_TRUE(result.alignment.accepted) << result.alignment.reason;
  EXPECT_NEAR(result.alignment.mean_scale, 0.2, 1e-6);
  EXPECT_LT(result.alignment.rmse_all, 1e-6);
  const common::Pose2 mapped = result.alignment.to_laser(result.visual[123].pose);
  EXPECT_NEAR(common::angle_difference(mapped.theta, path[123].pose.theta), 0.0, 1e-6);
}

TEST(AlignSpatial, FindsTheRightSideOfThePlaneWhereTheBodyAxesMislead) {
  const auto path = flat_path();
  auto camera = as_camera_path(path, 1.0);
  common::Pose3 upside_down;  // a camera mounted the wrong way up
  upside_down.rotation = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ());
  for (auto& pose : camera) pose.pose = pose.pose * upside_down;

  const SpatialAlignment result = align_spatial(common::to_spatial(path), camera, {});

  ASSERT_TRUE(result.alignment.accepted) << result.alignment.reason;
  EXPECT_LT(result.alignment.rmse_all, 1e-6);
}

TEST(AlignSpatial, RefusesAStraightPathInSpaceWithTheReason) {
  common::Trajectory3 camera;
  for (int i = 0; i < 100; ++i) {
    common::Pose3 pose;
    pose.translation = {0.0, 0.0, 0.1 * i};
    camera.push_back({kTestStart + i * kTestStep, pose});
  }

  const SpatialAlignment result = align_spatial(common::to_spatial(flat_path()), camera, {});

  EXPECT_FALSE(result.alignment.accepted);
  EXPECT_THAT(result.alignment.reason, HasSubstr("the visual trajectory has no plane of motion"));
}

}  // namespace
}  // namespace slamfuse::fusion
