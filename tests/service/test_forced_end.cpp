// SPDX-License-Identifier: BSD-3-Clause
#include "service/forced_end.hpp"

#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;

TEST(ForcedEndDeathTest, EndsAProcessThatHangs) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        force_end(50ms, "it hangs\n", 7);
        force_end(0ms, "never said\n", 8);
        std::this_thread::sleep_for(60s);
      },
      testing::ExitedWithCode(7), "^it hangs");
}

TEST(ForcedEndDeathTest, LeavesAProcessAloneThatEndsByItself) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        force_end(60s, "never said\n", 7);
        std::exit(0);
      },
      testing::ExitedWithCode(0), "^$");
}

}  // namespace
}  // namespace slamfuse::service
