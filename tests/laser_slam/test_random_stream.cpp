// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/random_stream.hpp"

#include <gtest/gtest.h>

namespace slamfuse::laser_slam {
namespace {

TEST(RandomStream, RepeatsForOneSeedAndDiffersBetweenStreams) {
  RandomStream a(7, 1), same(7, 1), other_stream(7, 2), other_seed(8, 1);
  for (int i = 0; i < 100; ++i) {
    const auto value = a.next();
    EXPECT_EQ(value, same.next());
    EXPECT_NE(value, other_stream.next());
    EXPECT_NE(value, other_seed.next());
  }
}

TEST(RandomStream, DrawsStandardNormals) {
  RandomStream stream(1, 1);
  double sum = 0.0, squares = 0.0, fourth = 0.0;
  constexpr int kCount = 100000;
  for (int i = 0; i < kCount; ++i) {
    const double value = stream.normal();
    sum += value;
    squares += value * value;
    fourth += value * value * value * value;
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.015);
  EXPECT_NEAR(squares / kCount, 1.0, 0.02);
  EXPECT_NEAR(fourth / kCount, 3.0, 0.15);
}

TEST(RandomStream, KeepsUniformNumbersBelowOne) {
  RandomStream stream(3, 0);
  double sum = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const double value = stream.uniform();
    ASSERT_GE(value, 0.0);
    ASSERT_LT(value, 1.0);
    sum += value;
  }
  EXPECT_NEAR(sum / 10000, 0.5, 0.01);
}

}  // namespace
}  // namespace slamfuse::laser_slam
