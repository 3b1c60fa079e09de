// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_accuracy.hpp"

#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using common::kNanosecondsPerSecond;
using common::PoseSource;

RunRequest live() {
  RunRequest request;
  request.live = true;
  return request;
}

TEST(RunAccuracy, LiveCoverageIsTheShareOfTimeWithAPose) {
  RunSummary summary;
  summary.first_stamp = 0;
  summary.last_stamp = 10 * kNanosecondsPerSecond;
  summary.counters[PoseSource::kLaser];
  summary.log.trajectories[PoseSource::kLaser] = {{0, {}}, {5 * kNanosecondsPerSecond, {}}};
  summary.log.covered[PoseSource::kLaser] = 5 * kNanosecondsPerSecond;
  ASSERT_TRUE(judge(live(), {}, summary));
  EXPECT_DOUBLE_EQ(summary.coverage.at(PoseSource::kLaser), 0.5);
}

// A session may end before its halves have found themselves: in a saved map, or right after a global search was asked.
TEST(RunAccuracy, LiveAHalfThatWasNeverFoundCoversNothing) {
  RunSummary summary;
  summary.last_stamp = 10 * kNanosecondsPerSecond;
  summary.counters[PoseSource::kLaser];
  summary.counters[PoseSource::kFused];
  summary.log.trajectories[PoseSource::kFused] = {};
  ASSERT_TRUE(judge(live(), {}, summary));
  EXPECT_EQ(summary.coverage.at(PoseSource::kLaser), 0.0);
  EXPECT_EQ(summary.coverage.at(PoseSource::kFused), 0.0);
}

}  // namespace
}  // namespace slamfuse::service
