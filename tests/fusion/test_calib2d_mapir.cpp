// SPDX-License-Identifier: BSD-3-Clause
// Alignment of a real drive: a monocular camera of unknown scale against a laser.
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

#include "common/tum.hpp"
#include "fusion/plane_of_motion.hpp"

namespace slamfuse::fusion {
namespace {

class Calib2dMapir : public testing::Test {
 protected:
  void SetUp() override {
    const char* recordings = std::getenv("SLAMFUSE_RECORDINGS");
    if (recordings == nullptr) GTEST_SKIP() << "SLAMFUSE_RECORDINGS is not set: needs real/calib2d_mapir";
    const std::filesystem::path folder = std::filesystem::path(recordings) / "real" / "calib2d_mapir";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " does not exist";
    laser_ = common::read_trajectory(folder / "laser.txt").value();
    camera_ = common::read_trajectory(folder / "camera.txt").value();
  }

  Alignment align(AlignmentMethod method) const {
    AlignmentOptions options;
    options.method = method;
    return align_spatial(laser_, camera_, options).alignment;
  }

  common::Trajectory3 laser_;
  common::Trajectory3 camera_;
};

TEST_F(Calib2dMapir, SimilarityFindsTheScaleFromCameraUnitsToMetres) {
  AlignmentOptions options;
  options.method = AlignmentMethod::kSimilarity;
  options.offsets.estimate = false;
  const Alignment alignment = align_spatial(laser_, camera_, options).alignment;

  ASSERT_TRUE(alignment.accepted) << alignment.reason;
  EXPECT_NEAR(alignment.scale.x() / 0.243, 1.0, 0.01);
  EXPECT_LE(alignment.rmse, 0.033);
  EXPECT_LE(alignment.rmse_all, 0.033);
}

TEST_F(Calib2dMapir, TheDefaultMethodIsNoWorseThanSeed004) {
  const Alignment by_default = align(AlignmentOptions{}.method);
  const Alignment seed = align(AlignmentMethod::kSeed004);

  ASSERT_TRUE(by_default.accepted) << by_default.reason;
  ASSERT_TRUE(seed.accepted) << seed.reason;
  EXPECT_LT(by_default.heldout_rmse, seed.heldout_rmse);
  EXPECT_NEAR(seed.scale.x() / 0.255, 1.0, 0.03);  // the extents alone give 0.255 and 0.243
  EXPECT_NEAR(seed.scale.y() / 0.243, 1.0, 0.03);
}

TEST_F(Calib2dMapir, LeverArmAndClockOffsetOfTheEvenPosesHoldForTheOddOnes) {
  const common::Trajectory2 laser = common::to_planar(laser_);
  common::Trajectory2 even;
  common::Trajectory2 odd;
  for (const auto& pose : common::to_planar(camera_)) (even.size() > odd.size() ? odd : even).push_back(pose);

  AlignmentOptions options;
  options.pairing.min_step = 0.0;
  const Alignment alignment = align_trajectories(laser, even, options);

  ASSERT_TRUE(alignment.accepted) << alignment.reason;
  EXPECT_GT(alignment.lever_arm.norm(), 0.05);
  double sum = 0.0;
  int count = 0;
  for (const auto& pose : to_laser_frame(odd, alignment)) {
    const auto truth = common::pose_at(laser, pose.stamp, common::kNanosecondsPerSecond / 2);
    if (!truth) continue;
    sum += (pose.pose.translation() - truth->translation()).squaredNorm();
    ++count;
  }
  ASSERT_GT(count, 100);
  EXPECT_LE(std::sqrt(sum / count), 0.018);
  RecordProperty("odd_rmse_mm", static_cast<int>(1e3 * std::sqrt(sum / count)));
}

}  // namespace
}  // namespace slamfuse::fusion
