// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_recorder.hpp"

#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using common::PoseSource;

common::PoseEstimate estimate_at(common::Nanoseconds stamp) {
  common::PoseEstimate estimate;
  estimate.stamp = stamp;
  estimate.source = PoseSource::kLaser;
  return estimate;
}

TEST(RunRecorder, KeepsEverythingOfAReplay) {
  RunRecorder recorder;
  for (int i = 0; i < 1000; ++i) recorder.on_estimate(estimate_at(i));
  EXPECT_EQ(recorder.log().estimates.at(PoseSource::kLaser).size(), 1000u);
  EXPECT_EQ(recorder.log().trajectories.at(PoseSource::kLaser).size(), 1000u);
}

TEST(RunRecorder, IsBoundedInAService) {
  constexpr std::size_t kMost = 100;
  RunRecorder recorder(kMost);
  for (int i = 0; i < 100000; ++i) {
    recorder.on_odometry({i, "odom0", {}, 0.0, 0.0});
    recorder.on_estimate(estimate_at(i));
    recorder.on_status({i, PoseSource::kFused, fusion::Verdict::kTracking, 1.0, {}});
    recorder.on_event({i, "laser", "lost", "why"});
  }
  const RunLog log = recorder.log();
  EXPECT_LE(log.trajectories.at(PoseSource::kOdometry).size(), kMost);
  EXPECT_LE(log.estimates.at(PoseSource::kLaser).size(), kMost);
  EXPECT_LE(log.status.size(), kMost);
  ASSERT_EQ(log.events.size(), kMost);
  EXPECT_EQ(log.trajectories.at(PoseSource::kLaser).front().stamp, 0);
  EXPECT_EQ(log.trajectories.at(PoseSource::kLaser).back().stamp, 99999);
  EXPECT_EQ(log.events.front().stamp, 0);
  EXPECT_EQ(log.events.back().stamp, 99999);
}

TEST(RunRecorder, KnowsWhatThePosesCoverThoughItKeepsFew) {
  constexpr common::Nanoseconds kSecond = 1'000'000'000;
  RunRecorder recorder(10);
  for (int i = 0; i <= 1000; ++i) recorder.on_estimate(estimate_at(i * kSecond / 10));  // 100 s
  recorder.on_estimate(estimate_at(110 * kSecond));
  const RunLog log = recorder.log();
  EXPECT_EQ(log.covered.at(PoseSource::kLaser), 101 * kSecond);  // 100.5 and 0.5 s
  const auto& states = log.states.at(PoseSource::kLaser);
  ASSERT_EQ(states.size(), 2U) << "what a report says of the states does not hang on the poses kept";
  EXPECT_EQ(states[0].to, 100 * kSecond + kSecond / 2);
  EXPECT_EQ(states[1].from, 110 * kSecond);
}

TEST(RunRecorder, ALostPoseIsAnEstimateButNoPartOfThePath) {
  RunRecorder recorder;
  auto lost = estimate_at(5);
  lost.state = common::TrackingState::kLost;
  recorder.on_estimate(lost);
  EXPECT_EQ(recorder.log().estimates.at(PoseSource::kLaser).size(), 1u);
  EXPECT_FALSE(recorder.log().trajectories.contains(PoseSource::kLaser));
}

}  // namespace
}  // namespace slamfuse::service
