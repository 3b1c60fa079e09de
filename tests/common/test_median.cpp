// SPDX-License-Identifier: BSD-3-Clause
#include "common/median.hpp"

#include <gtest/gtest.h>

namespace slamfuse::common {
namespace {

TEST(Median, IsTheMiddleOrTheUpperOfTwo) {
  EXPECT_EQ(median({3.0}), 3.0);
  EXPECT_EQ(median({5.0, -1.0, 2.0}), 2.0);
  EXPECT_EQ(median({4.0, 1.0, 3.0, 2.0}), 3.0);
}

}  // namespace
}  // namespace slamfuse::common
