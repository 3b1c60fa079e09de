// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/measurement_model.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

TEST(FlawOf, NamesWhatCannotBeUsed) {
  common::PoseEstimate estimate;
  estimate.covariance = Eigen::Matrix3d::Identity();
  EXPECT_EQ(flaw_of(estimate), std::nullopt);

  auto fused = estimate;
  fused.source = common::PoseSource::kFused;
  EXPECT_TRUE(flaw_of(fused).has_value());
  auto nowhere = estimate;
  nowhere.pose.y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(flaw_of(nowhere).has_value());
  auto impossible = estimate;
  impossible.covariance(0, 0) = -1.0;
  EXPECT_TRUE(flaw_of(impossible).has_value());
}

TEST(AlignmentError, IsTheLargerOfTheHeldOutAndTheForwardError) {
  Alignment alignment;
  alignment.method = AlignmentMethod::kRigid;
  alignment.heldout_rmse = 0.02;
  alignment.forward_rmse = 0.01;
  EXPECT_NEAR(alignment_error(alignment, {1.0, 2.0})(0, 0), 0.02 * 0.02 / 2.0, 1e-12);

  alignment.forward_rmse = 0.05;
  EXPECT_NEAR(alignment_error(alignment, {1.0, 2.0})(0, 0), 0.05 * 0.05 / 2.0, 1e-12);
}

TEST(AlignmentError, IsMoreWhereAScaleWasFitted) {
  Alignment alignment;
  alignment.heldout_rmse = 0.02;
  alignment.method = AlignmentMethod::kRigid;
  const double rigid = alignment_error(alignment, {1.0, 2.0})(1, 1);
  alignment.method = AlignmentMethod::kSimilarity;

  EXPECT_GT(alignment_error(alignment, {1.0, 2.0})(1, 1), 10.0 * rigid);
}

TEST(VisualPose, TakesAnAlignedPoseBack) {
  Alignment alignment;
  alignment.map = stretched_map(50.0, 2.0, 2.0, 1.0, -3.0);
  alignment.heading_offset = 0.87;
  const UncertainPose visual{{0.4, -1.2, 2.9}, Eigen::Vector3d(0.01, 0.02, 0.003).asDiagonal()};

  const UncertainPose back = visual_pose(aligned_pose(visual, alignment), alignment);

  EXPECT_LT(difference(back.pose, visual.pose).norm(), 1e-12);
  EXPECT_TRUE(back.covariance.isApprox(visual.covariance, 1e-12));
}

}  // namespace
}  // namespace slamfuse::fusion
