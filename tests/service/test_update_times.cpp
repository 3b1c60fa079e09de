// SPDX-License-Identifier: BSD-3-Clause
#include "service/update_times.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

TEST(UpdateTimes, AreZeroWithoutASample) {
  const UpdateTimes times = summarise_update_times({});
  EXPECT_EQ(times.median, 0.0);
  EXPECT_EQ(times.max, 0.0);
}

TEST(UpdateTimes, OfOneSampleAreThatSample) {
  const UpdateTimes times = summarise_update_times({4.0});
  EXPECT_EQ(times.median, 4.0);
  EXPECT_EQ(times.p99, 4.0);
}

TEST(UpdateTimes, AreNearestRankPercentilesWhateverTheOrder) {
  std::vector<double> samples;
  for (int i = 100; i >= 1; --i) samples.push_back(i);
  const UpdateTimes times = summarise_update_times(samples);
  EXPECT_EQ(times.median, 50.0);
  EXPECT_EQ(times.p95, 95.0);
  EXPECT_EQ(times.p99, 99.0);
  EXPECT_EQ(times.max, 100.0);
}

}  // namespace
}  // namespace slamfuse::service
