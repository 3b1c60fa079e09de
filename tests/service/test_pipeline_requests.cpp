// SPDX-License-Identifier: BSD-3-Clause
#include "service/pipeline_requests.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "service/fake_recording.hpp"
#include "service/fake_stages.hpp"
#include "service/pipeline.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using common::PoseSource;

TEST(PipelineRequests, AreCarriedOutInTheirOrder) {
  PipelineRequests requests;
  std::jthread pipeline([&](const std::stop_token& done) {
    while (!done.stop_requested()) {
      requests.serve([](const PipelineRequest& request) -> PipelineRequests::Answer {
        if (std::holds_alternative<SearchMap>(request)) return common::failed("no map");
        return std::string("aligned");
      });
      std::this_thread::sleep_for(1ms);
    }
  });
  EXPECT_EQ(requests.ask(AlignNow{}, 5s).value(), "aligned");
  EXPECT_EQ(requests.ask(SearchMap{}, 5s).error().message, "no map");
}

TEST(PipelineRequests, AreGivenUpWhenNothingIsProcessed) {
  PipelineRequests requests;
  const auto answer = requests.ask(AlignNow{}, 10ms);
  ASSERT_FALSE(answer);
  EXPECT_THAT(answer.error().message, testing::HasSubstr("nothing was done"));
  bool carried_out = false;
  requests.serve([&](const PipelineRequest&) -> PipelineRequests::Answer {
    carried_out = true;
    return std::string();
  });
  EXPECT_FALSE(carried_out);
}

// A pipeline fed slowly enough for a request to come in.
struct SlowRun {
  PipelineRequests requests;
  FakeModule laser{PoseSource::kLaser, [] { std::this_thread::sleep_for(5ms); }};
  FakeModule visual{PoseSource::kVisual};
  FakeFusion fusion;
  Transcript told;

  PipelineRequests::Answer run_and_ask(const PipelineRequest& request) {
    FakeRecording recording(rounds(60));
    PipelineOptions options;
    options.threads = 2;
    options.queue_capacity = 8;
    options.command_delay = 2;
    std::jthread pipeline([&] {
      const std::atomic<bool> no_stop{false};
      run_pipeline({&recording, {{&laser}, {&visual}}, &fusion, &told, &requests}, options, no_stop);
    });
    return requests.ask(request, 5s);
  }
};

TEST(PipelineRequests, PlaceTheLaserHalfWithoutAlignment) {
  SlowRun run;
  const auto answer = run.run_and_ask(PlaceRobot{{{5.0, 0.0, 0.0}}});
  ASSERT_TRUE(answer);
  EXPECT_THAT(*answer, testing::HasSubstr("not aligned"));
  EXPECT_EQ(std::ranges::count_if(run.laser.calls, [](const auto& call) { return call.starts_with("set pose"); }), 1);
  EXPECT_EQ(std::ranges::count_if(run.visual.calls, [](const auto& call) { return call.starts_with("set pose"); }), 0);
}

TEST(PipelineRequests, PlaceTheVisualHalfInItsOwnMap) {
  SlowRun run;
  fusion::Alignment alignment;
  alignment.accepted = true;
  alignment.map.linear = 2.0 * Eigen::Matrix2d::Identity();  // laser metres are half visual units
  alignment.map.translation = {1.0, 0.0};
  run.fusion.align(alignment);
  const auto answer = run.run_and_ask(PlaceRobot{{{5.0, 0.0, 0.0}}});
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_EQ(std::ranges::count_if(run.laser.calls, [](const auto& call) { return call.starts_with("set pose"); }), 1);
  const auto placed =
      std::ranges::find_if(run.visual.calls, [](const auto& call) { return call.starts_with("set pose"); });
  ASSERT_NE(placed, run.visual.calls.end());
  EXPECT_NEAR(std::stod(placed->substr(9)), 2.0, 0.5);  // the fake odometry carries it on
}

TEST(PipelineRequests, TellWhyAnAlignmentWasRefused) {
  SlowRun run;
  fusion::Alignment alignment;
  alignment.reason = "too straight";
  run.fusion.align(alignment);
  const auto answer = run.run_and_ask(AlignNow{});
  ASSERT_FALSE(answer);
  EXPECT_THAT(answer.error().message, testing::HasSubstr("too straight"));
}

}  // namespace
}  // namespace slamfuse::service
