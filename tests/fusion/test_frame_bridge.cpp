// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/frame_bridge.hpp"

#include <gtest/gtest.h>

#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

Alignment alignment_by(const PlanarAffine& map, double heading_offset) {
  Alignment alignment;
  alignment.accepted = true;
  alignment.method = AlignmentMethod::kRigid;
  alignment.map = map;
  alignment.heading_offset = heading_offset;
  alignment.heldout_rmse = 0.03;
  return alignment;
}

UncertainPose pose(double x, double y, double theta) {
  return {{x, y, theta}, Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal()};
}

TEST(FrameBridge, IsClosedWithoutAnAlignment) {
  FrameBridge bridge;

  EXPECT_FALSE(bridge.to_laser(pose(1.0, 2.0, 0.3)).has_value());
  EXPECT_FALSE(bridge.to_visual(pose(1.0, 2.0, 0.3), false).has_value());
  EXPECT_FALSE(bridge.scale().has_value());
}

TEST(FrameBridge, BringsAPoseOverAndBackWithTheErrorOfTheAlignment) {
  FrameBridge bridge;
  EXPECT_FALSE(bridge.use(alignment_by(stretched_map(40.0, 1.0, 1.0, 1.0, -3.0), 0.7)).has_value());

  const auto laser = bridge.to_laser(pose(1.0, 2.0, 3.0));

  ASSERT_TRUE(laser.has_value());
  EXPECT_NEAR(laser->covariance(0, 0), 1e-4 + 0.03 * 0.03 / 2.0, 1e-9);
  EXPECT_LT(difference(bridge.to_visual(*laser, true)->pose, pose(1.0, 2.0, 3.0).pose).norm(), 1e-12);
  EXPECT_GT(bridge.to_visual(*laser, false)->covariance(0, 0), bridge.to_visual(*laser, true)->covariance(0, 0));
}

TEST(FrameBridge, TellsHowFarANewAlignmentMovesTheLastPose) {
  FrameBridge bridge;
  bridge.use(alignment_by(stretched_map(40.0, 1.0, 1.0, 1.0, -3.0), 0.7));
  const common::Pose2 before = bridge.to_laser(pose(1.0, 2.0, 3.0))->pose;

  const auto step = bridge.use(alignment_by(stretched_map(41.0, 1.0, 1.0, 1.1, -3.2), 0.72));

  ASSERT_TRUE(step.has_value());
  const common::Pose2 after = bridge.to_laser(pose(1.0, 2.0, 3.0))->pose;
  EXPECT_LT((difference(after, before) - *step).norm(), 1e-12);
}

TEST(FrameBridge, ForgetsThePlaceAfterACarry) {
  FrameBridge bridge;
  bridge.use(alignment_by(stretched_map(40.0, 1.0, 1.0, 1.0, -3.0), 0.7));
  bridge.to_laser(pose(1.0, 2.0, 3.0));

  bridge.forget_place();

  EXPECT_FALSE(bridge.use(alignment_by(stretched_map(41.0, 1.0, 1.0, 1.1, -3.2), 0.72)).has_value());
}

}  // namespace
}  // namespace slamfuse::fusion
