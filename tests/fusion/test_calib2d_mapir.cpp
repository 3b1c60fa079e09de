// SPDX-License-Identifier: BSD-3-Clause
// Alignment of a real drive: a monocular camera of unknown scale against a laser.
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
  const Alignment alignment = align(AlignmentMethod::kSimilarity);

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

}  // namespace
}  // namespace slamfuse::fusion
