// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/uncertain_pose.hpp"

#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Core>

namespace slamfuse::fusion {
namespace {

UncertainPose pose(double x, double y, double theta, double vx, double vy, double vtheta) {
  return {{x, y, theta}, Eigen::Vector3d(vx, vy, vtheta).asDiagonal()};
}

TEST(SquaredDistance, IsOneForAnErrorOfOneStandardDeviation) {
  EXPECT_NEAR(squared_distance(pose(1.0, 0, 0, 0.5, 1, 1), pose(0.0, 0, 0, 0.5, 1, 1)), 1.0, 1e-12);
  EXPECT_NEAR(squared_distance(pose(0, 0, 3.1, 1, 1, 0.01), pose(0, 0, -3.1, 1, 1, 0.01)),
              std::pow(2.0 * std::numbers::pi - 6.2, 2) / 0.02, 1e-9);
}

}  // namespace
}  // namespace slamfuse::fusion
