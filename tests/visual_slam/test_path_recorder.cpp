// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/path_recorder.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace slamfuse::visual_slam {
namespace {

using common::kNanosecondsPerSecond;
using common::Pose2;
using common::Pose3;

/// A robot that drives a metre a second along x, with an estimate each second; its odometry tells the truth.
class PathRecorderTest : public ::testing::Test {
 protected:
  void drive(int seconds, bool lost, bool keyframes) {
    for (int i = 0; i < seconds; ++i) {
      ++now_;
      filter_.predict({1.0, Pose2{1.0, 0.0, 0.0}});
      odometry_ = odometry_ * Pose2{1.0, 0.0, 0.0};
      if (keyframes) filter_.add_keyframe(now_ * kNanosecondsPerSecond, 100);
      add(lost);
    }
  }
  void add(bool lost) {
    path_.add(now_ * kNanosecondsPerSecond, common::to_pose3(odometry_), lost, filter_, pictures_);
  }
  void place(const Pose2& pose) { filter_.set_pose(pose, 1e-4 * Eigen::Matrix3d::Identity()); }

  std::vector<long> seconds() const {
    std::vector<long> result;
    for (const auto& pose : path_.path(filter_))
      result.push_back(static_cast<long>(pose.stamp / kNanosecondsPerSecond));
    return result;
  }

  Ekf filter_{FilterOptions{}, MotionOptions{}};
  ObservationLog pictures_{MapOptions{}};
  PathRecorder path_{common::kKeepAll};
  Pose2 odometry_;
  common::Nanoseconds now_ = 0;
};

TEST_F(PathRecorderTest, EmptyBeforeTheFirstEstimate) { EXPECT_TRUE(path_.path(filter_).empty()); }

TEST_F(PathRecorderTest, HasEveryPoseOfANormalDrive) {
  drive(3, false, true);
  drive(3, false, false);
  const auto path = path_.path(filter_);
  ASSERT_EQ(path.size(), 6u);
  for (const auto& pose : path) {
    EXPECT_NEAR(pose.pose.translation.x(), static_cast<double>(pose.stamp) / kNanosecondsPerSecond, 1e-6);
  }
}

TEST_F(PathRecorderTest, ForgetsWhatIsEstimatedAgain) {
  drive(3, false, true);
  path_.freeze(filter_);
  drive(2, false, true);
  path_.forget_since(2 * kNanosecondsPerSecond);
  EXPECT_EQ(seconds(), (std::vector<long>{1}));
  drive(1, false, true);
  EXPECT_EQ(seconds(), (std::vector<long>{1, 6}));
}

TEST_F(PathRecorderTest, BridgesALossBetweenKeyframesThatHangTogether) {
  drive(2, false, true);
  drive(2, true, false);
  drive(1, false, true);
  EXPECT_EQ(seconds(), (std::vector<long>{1, 2, 3, 4, 5}));
}

TEST_F(PathRecorderTest, LeavesOutWhereItIsLostWithoutEnd) {
  drive(2, false, true);
  drive(2, true, false);
  EXPECT_EQ(seconds(), (std::vector<long>{1, 2}));
}

// Nobody knows whether the robot was carried before or after the images between.
TEST_F(PathRecorderTest, LeavesOutTheTimeBeforeItIsFoundElsewhere) {
  drive(2, false, true);
  drive(2, true, true);
  path_.restart_since(3 * kNanosecondsPerSecond);
  place({10.0, 5.0, 0.0});
  drive(2, false, true);
  EXPECT_EQ(seconds(), (std::vector<long>{1, 2, 5, 6}));
  EXPECT_NEAR(path_.path(filter_)[2].pose.translation.y(), 5.0, 1e-6);
}

TEST_F(PathRecorderTest, WhatIsFrozenStays) {
  drive(2, false, true);
  drive(1, true, false);
  path_.freeze(filter_);
  place({10.0, 5.0, 0.0});
  drive(1, false, true);
  const auto path = path_.path(filter_);
  EXPECT_EQ(seconds(), (std::vector<long>{1, 2, 4}));
  EXPECT_NEAR(path[1].pose.translation.x(), 2.0, 1e-6);
}

TEST_F(PathRecorderTest, InBoundedMemoryWhatKeyframesAndPicturesHangOnStays) {
  constexpr std::size_t kMost = 100;
  path_ = PathRecorder(kMost);
  const std::vector<Track> seen{{0, {100.0, 100.0}}};
  for (int i = 0; i < 20; ++i) {
    drive(1, false, true);
    drive(20, false, false);
    pictures_.offer(0, now_ * kNanosecondsPerSecond, odometry_, seen);
    drive(79, false, false);
  }
  const auto path = path_.path(filter_);
  EXPECT_LE(path.size(), kMost + 40);
  const std::vector<long> kept = seconds();
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(std::ranges::binary_search(kept, 100 * i + 1)) << i;
    EXPECT_TRUE(std::ranges::binary_search(kept, 100 * i + 21)) << i;
  }
  int in_whole_blocks = 0;  // two seconds that begin with an even one
  for (const long second : kept) {
    in_whole_blocks += second % 2 == 0 && std::ranges::binary_search(kept, second + 1) ? 2 : 0;
  }
  EXPECT_GE(in_whole_blocks, 40);
  for (const auto& pose : path) EXPECT_NEAR(pose.pose.translation.x(), common::to_seconds(pose.stamp), 1e-6);
}

TEST_F(PathRecorderTest, WhatIsFrozenIsThinnedAndStays) {
  constexpr std::size_t kMost = 50;
  path_ = PathRecorder(kMost);
  for (int i = 0; i < 500; ++i) {
    drive(1, false, false);
    path_.freeze(filter_);
  }
  const common::Nanoseconds moved = now_ * kNanosecondsPerSecond;
  place({1000.0, 5.0, 0.0});
  drive(20, false, true);
  path_.restart_since(moved + 10 * kNanosecondsPerSecond);
  path_.forget_since(moved + 15 * kNanosecondsPerSecond);
  drive(1, false, true);

  const auto path = path_.path(filter_);
  EXPECT_LE(path.size(), kMost + 21);
  EXPECT_GE(path.size(), kMost / 2);
  for (const auto& pose : path) {
    const double x = common::to_seconds(pose.stamp);
    EXPECT_NEAR(pose.pose.translation.x(), pose.stamp <= moved ? x : 1000.0 + x - 500.0, 1e-6) << x;
  }
}

}  // namespace
}  // namespace slamfuse::visual_slam
