// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/frozen_scan.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace slamfuse::laser_slam {
namespace {

common::LaserScan scan_of(float range, std::size_t returns = 100) {
  common::LaserScan scan;
  for (std::size_t n = 0; n < returns; ++n)
    scan.ranges.push_back(range + (n * 7 % 11 < 5 ? 0.01F : 0.0F) + 0.001F * static_cast<float>(n));
  scan.ranges.resize(200, std::numeric_limits<float>::infinity());
  scan.ranges.push_back(std::numeric_limits<float>::quiet_NaN());
  return scan;
}

TEST(FrozenScan, IsToldByTheWheels) {
  FrozenScan frozen;
  frozen.moved_to({0.0, 0.0, 0.0});
  EXPECT_TRUE(frozen.check(scan_of(2.0F)).has_value());
  frozen.moved_to({0.02, 0.0, 0.0});
  EXPECT_TRUE(frozen.check(scan_of(2.0F)).has_value());

  frozen.moved_to({0.06, 0.0, 0.0});
  const auto repeated = frozen.check(scan_of(2.0F));

  ASSERT_FALSE(repeated.has_value());
  EXPECT_NE(repeated.error().message.find("frozen"), std::string::npos);
  frozen.moved_to({0.06, 0.0, 0.1});
  EXPECT_TRUE(frozen.check(scan_of(2.01F)).has_value());
}

TEST(FrozenScan, ASensorWithoutNoiseMaySeeTheSameAllAlongACorridor) {
  FrozenScan frozen;
  common::LaserScan smooth;
  for (int n = 10; n < 170; ++n) smooth.ranges.push_back(static_cast<float>(1.0 / std::sin(n * 0.0174533)));
  for (int n = 0; n < 100; ++n) {
    frozen.moved_to({0.1 * (n / 2), 0.0, 0.0});
    EXPECT_TRUE(frozen.check(smooth).has_value());
  }
}

TEST(FrozenScan, ATurnTellsToo) {
  FrozenScan frozen;
  frozen.moved_to({1.0, 1.0, 3.1});
  EXPECT_TRUE(frozen.check(scan_of(2.0F)).has_value());
  frozen.moved_to({1.0, 1.0, -3.1});

  EXPECT_FALSE(frozen.check(scan_of(2.0F)).has_value());
}

TEST(FrozenScan, ARobotThatStandsMaySeeTheSameForever) {
  FrozenScan frozen;
  frozen.moved_to({0.0, 0.0, 0.0});

  for (int n = 0; n < 100; ++n) EXPECT_TRUE(frozen.check(scan_of(2.0F)).has_value());
}

TEST(FrozenScan, ARobotInTheOpenSeesTheSameNothing) {
  FrozenScan frozen;
  for (int n = 0; n < 100; ++n) {
    frozen.moved_to({0.1 * n, 0.0, 0.0});
    EXPECT_TRUE(frozen.check(scan_of(5.0F, 3)).has_value());
  }
}

TEST(FrozenScan, ADriverMaySendANumberForNothing) {
  FrozenScan frozen;
  common::LaserScan scan;
  scan.ranges.assign(360, 65.5F);
  for (int n = 0; n < 100; ++n) {
    frozen.moved_to({0.1 * n, 0.0, 0.0});
    EXPECT_TRUE(frozen.check(scan).has_value());
  }
}

TEST(FrozenScan, OdometryThatBeginsAnewIsNoDrive) {
  FrozenScan frozen;
  frozen.moved_to({7.0, 3.0, 1.0});
  EXPECT_TRUE(frozen.check(scan_of(2.0F)).has_value());

  frozen.moved_to({0.0, 0.0, 0.0});

  EXPECT_TRUE(frozen.check(scan_of(2.0F)).has_value());
  EXPECT_TRUE(frozen.check(scan_of(2.0F)).has_value());
}

TEST(FrozenScan, WithoutOdometryNothingTells) {
  FrozenScan frozen;

  for (int n = 0; n < 100; ++n) EXPECT_TRUE(frozen.check(scan_of(2.0F)).has_value());
}

}  // namespace
}  // namespace slamfuse::laser_slam
