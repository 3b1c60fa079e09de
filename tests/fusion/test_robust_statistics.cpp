// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/robust_statistics.hpp"

#include <gtest/gtest.h>

namespace slamfuse::fusion {
namespace {

TEST(TukeyWeight, FallsFromOneToZeroAtItsConstant) {
  EXPECT_EQ(tukey_weight(0.0, 0.1), 1.0);
  const double edge = kTukeyConstant * 0.1;
  EXPECT_EQ(tukey_weight(1.0001 * edge * edge, 0.1), 0.0);
  EXPECT_NEAR(tukey_weight(0.25 * edge * edge, 0.1), 0.5625, 1e-12);
}

TEST(EvenlySpread, KeepsFirstAndOrderAndNeverMore) {
  const std::vector<int> items{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  EXPECT_EQ(evenly_spread(items, 10), items);
  EXPECT_EQ(evenly_spread(items, 100), items);
  EXPECT_EQ(evenly_spread(items, 4), (std::vector<int>{0, 2, 5, 7}));
  EXPECT_TRUE(evenly_spread(items, 0).empty());
}

}  // namespace
}  // namespace slamfuse::fusion
