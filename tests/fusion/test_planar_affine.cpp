// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/planar_affine.hpp"

#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

TEST(PlanarAffine, ComposesAndInverts) {
  const PlanarAffine a = stretched_map(40.0, 2.0, 3.0, 1.0, 2.0);
  const PlanarAffine b = stretched_map(-70.0, 0.5, 0.7, -4.0, 0.3);
  const Eigen::Vector2d point(0.3, -1.9);

  EXPECT_TRUE(((a * b) * point).isApprox(a * (b * point), 1e-12));
  EXPECT_TRUE((a.inverse() * (a * point)).isApprox(point, 1e-12));
  EXPECT_TRUE((a.matrix() * point.homogeneous()).head<2>().isApprox(a * point, 1e-12));
}

TEST(TakeApart, FindsRotationAndScalesWhenTheVisualAxesAreStretched) {
  const AffineParts parts = take_apart(stretched_map(-155.0, 2.0, 2.5, 0.0, 0.0));

  EXPECT_NEAR(common::to_degrees(parts.rotation), -155.0, 1e-9);
  EXPECT_NEAR(parts.scale.x(), 2.0, 1e-12);
  EXPECT_NEAR(parts.scale.y(), 2.5, 1e-12);
  EXPECT_FALSE(parts.scale_along_target_axes);
  EXPECT_NEAR(parts.mean_scale, std::sqrt(5.0), 1e-12);
}

TEST(TakeApart, FindsRotationAndScalesWhenTheLaserAxesAreStretched) {
  const common::Pose2 turn{0.0, 0.0, common::to_radians(25.0)};
  const AffineParts parts = take_apart({Eigen::Vector2d(0.2, 0.3).asDiagonal() * turn.rotation(), {}});

  EXPECT_NEAR(common::to_degrees(parts.rotation), 25.0, 1e-9);
  EXPECT_NEAR(parts.scale.x(), 0.2, 1e-12);
  EXPECT_NEAR(parts.scale.y(), 0.3, 1e-12);
  EXPECT_TRUE(parts.scale_along_target_axes);
}

TEST(TakeApart, OfASimilarityGivesItsScaleTwice) {
  const AffineParts parts = take_apart(to_affine({0.243, {1.0, 2.0, 0.5}}));

  EXPECT_NEAR(parts.rotation, 0.5, 1e-12);
  EXPECT_NEAR(parts.scale.x(), 0.243, 1e-12);
  EXPECT_NEAR(parts.scale.y(), 0.243, 1e-12);
}

}  // namespace
}  // namespace slamfuse::fusion
