// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/path_refinement.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "laser_slam/submap.hpp"
#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

using common::Pose2;

/// A drive twice along the four corridors of the ring, a keyframe each 0.25 m, and what odometry and filter made of it.
struct RingDrive {
  std::vector<Pose2> truth;
  std::vector<Keyframe> keyframes;
  std::vector<Pose2> odometry;  // integrated
};

/// `drift` is added to every step of the odometry.
RingDrive drive_twice(const Pose2& drift) {
  RingDrive drive;
  const auto walls = testing::ring();
  const auto laser = testing::full_circle_laser();
  RandomStream noise(7, 0);
  Pose2 pose;
  double path = 0.0;
  std::vector<Pose2> poses;
  for (int side = 0; side < 8; ++side) {
    for (int i = 0; i < 48; ++i) poses.push_back(pose = pose * Pose2{0.25, 0.0, 0.0});
    for (int i = 0; i < 4; ++i) poses.push_back(pose = pose * Pose2{0.0, 0.0, std::numbers::pi / 8.0});
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose2 back = poses.front().inverse();
    drive.truth.push_back(back * poses[i]);
    Keyframe keyframe;
    keyframe.scan = StoredScan(
        *project_scan(testing::scan_at(walls, laser, 0, poses[i], &noise), laser, {}, Eigen::Vector3d::Zero()));
    keyframe.mapped = true;
    Pose2 told;
    if (i > 0) {
      const Pose2 step = poses[i - 1].inverse() * poses[i];
      told = step * drift;
      path += std::hypot(step.x, step.y);
      keyframe.motions = {{told, Eigen::Vector3d(1e-3, 1e-3, 1e-3).asDiagonal(), told}};
    }
    keyframe.path_length = path;
    drive.odometry.push_back(i == 0 ? Pose2{} : drive.odometry.back() * told);
    drive.keyframes.push_back(std::move(keyframe));
  }
  return drive;
}

double rms(const std::vector<Pose2>& path, const std::vector<Pose2>& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < path.size(); ++i) sum += std::pow(testing::distance(path[i], truth[i]), 2);
  return std::sqrt(sum / static_cast<double>(path.size()));
}

ScanMatcher matcher() { return {ScanMatcherOptions{}, 0.05}; }

TEST(MapLocally, PutsEachScanInTwoSubmapsAndForgetsNothing) {
  const RingDrive drive = drive_twice({});
  const LocalMapping local = map_locally(drive.keyframes, drive.truth, matcher(), {}, 20);
  std::vector<int> times(drive.keyframes.size(), 0);
  for (const Submap& submap : local.submaps) {
    EXPECT_LE(submap.members.size(), 20u);
    for (const int member : submap.members) ++times[static_cast<std::size_t>(member)];
  }
  for (std::size_t i = 10; i + 10 < times.size(); ++i) EXPECT_EQ(times[i], 2) << i;
  EXPECT_EQ(local.motions.size() + 1, drive.keyframes.size());
  for (const PoseConstraint& membership : local.memberships) {
    const Pose2 expected =
        drive.truth[static_cast<std::size_t>(local.submaps[static_cast<std::size_t>(membership.from)].members.front())]
            .inverse() *
        drive.truth[static_cast<std::size_t>(membership.to)];
    EXPECT_LT(testing::distance(membership.measured, expected), 0.05);
  }
}

TEST(RefinePath, SpreadsWhatTheFilterLeftAtTheLoop) {
  // Once round the path drifts, then it jumps to where the second round fits: what a filter does that closes late.
  const RingDrive drive = drive_twice({0.002, 0.0, 0.0});
  const std::size_t half = drive.truth.size() / 2;
  std::vector<Pose2> filtered = drive.odometry;
  for (std::size_t i = half; i < filtered.size(); ++i) filtered[i] = drive.truth[i];
  const double before = rms(filtered, drive.truth);
  ASSERT_GT(before, 0.05);
  const auto refined = refine_path(drive.keyframes, filtered, matcher(), {}, {}, 10.0, 2);
  ASSERT_EQ(refined.size(), filtered.size());
  EXPECT_EQ(refined[0].vector(), filtered[0].vector());
  EXPECT_LT(rms(refined, drive.truth), 0.5 * before);
}

TEST(RefinePath, IsTheSameWithAnyNumberOfThreads) {
  const RingDrive drive = drive_twice({0.002, 0.0, 0.0005});
  const auto one = refine_path(drive.keyframes, drive.truth, matcher(), {}, {}, 10.0, 1);
  const auto three = refine_path(drive.keyframes, drive.truth, matcher(), {}, {}, 10.0, 3);
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].vector(), three[i].vector()) << i;
}

TEST(RefinePath, GoesOnAfterThePoseWasSetFromOutside) {
  RingDrive drive = drive_twice({});
  const std::size_t set = drive.keyframes.size() / 2;
  drive.keyframes[set].scan = {};
  drive.keyframes[set].mapped = false;
  drive.keyframes[set].motions.clear();
  const auto refined = refine_path(drive.keyframes, drive.truth, matcher(), {}, {}, 10.0, 1);
  EXPECT_LT(rms(refined, drive.truth), 0.05);
}

TEST(RefinePath, TakesAnEmptyRunAndASingleScan) {
  EXPECT_TRUE(refine_path({}, {}, matcher(), {}, {}, 10.0, 2).empty());
  const RingDrive drive = drive_twice({});
  const auto one = refine_path({drive.keyframes[0]}, {drive.truth[0]}, matcher(), {}, {}, 10.0, 1);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].vector(), drive.truth[0].vector());
}

}  // namespace
}  // namespace slamfuse::laser_slam
