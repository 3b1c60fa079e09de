// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/past_poses.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "visual_slam/pose_block.hpp"

namespace slamfuse::visual_slam {
namespace {

class PastPosesTest : public ::testing::Test {
 protected:
  PastPosesTest()
      : robot_(
            state_.append(Eigen::Vector3d(1.0, 2.0, 0.5), BlockKind::kPose, {}, 0.01 * Eigen::Matrix3d::Identity())) {
    state_.append(Eigen::Vector3d::Zero(), BlockKind::kCalibration, {}, Eigen::Matrix3d::Identity());
  }

  /// Drives on and keeps the pose.
  void keep(common::Nanoseconds stamp) {
    past_.robot_moved();
    past_.add_keyframe(state_, robot_, stamp);
  }

  State state_;
  BlockId robot_;
  PastPoses past_;
};

TEST_F(PastPosesTest, OneMomentHasOnePoseWhoeverWantsIt) {
  const BlockId first = past_.anchor(state_, robot_, 5);
  EXPECT_EQ(past_.anchor(state_, robot_, 5), first);
  past_.add_keyframe(state_, robot_, 5);

  ASSERT_EQ(past_.all().size(), 1U);
  EXPECT_EQ(past_.all().front().anchored, 2);
  EXPECT_EQ(past_.keyframe_at(5), &past_.all().front());
  EXPECT_EQ(planar_pose(state_, first).y, 2.0);
}

TEST_F(PastPosesTest, ARobotThatMovedHasAnotherPose) {
  const BlockId first = past_.anchor(state_, robot_, 5);
  past_.robot_moved();
  EXPECT_NE(past_.anchor(state_, robot_, 5), first);
  EXPECT_NE(past_.anchor(state_, robot_, 6), first);
  EXPECT_EQ(past_.all().size(), 3U);
}

TEST_F(PastPosesTest, GoesWithItsLastLandmarkUnlessItIsAKeyframe) {
  const BlockId anchor = past_.anchor(state_, robot_, 1);
  past_.anchor(state_, robot_, 1);
  keep(2);

  past_.release(anchor);
  EXPECT_TRUE(past_.take_needless().empty());
  past_.release(anchor);
  EXPECT_EQ(past_.take_needless(), std::vector<BlockId>{anchor});
  ASSERT_EQ(past_.all().size(), 1U);
  EXPECT_EQ(past_.all().front().stamp, 2);
  EXPECT_EQ(past_.keyframe_at(1), nullptr);
}

TEST_F(PastPosesTest, TheKeyframeBetweenNearNeighboursIsSpared) {
  for (const common::Nanoseconds stamp : {0, 100, 110, 120, 200}) keep(stamp);

  EXPECT_FALSE(past_.limit_keyframes(5));
  EXPECT_TRUE(past_.limit_keyframes(4));

  EXPECT_EQ(past_.take_needless().size(), 1U);
  EXPECT_EQ(past_.keyframe_at(110), nullptr);
  for (const common::Nanoseconds stamp : {0, 100, 120, 200}) EXPECT_NE(past_.keyframe_at(stamp), nullptr) << stamp;
}

}  // namespace
}  // namespace slamfuse::visual_slam
