// SPDX-License-Identifier: BSD-3-Clause
#include "service/pipeline.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "service/fake_recording.hpp"
#include "service/fake_stages.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using common::PoseSource;

const std::atomic<bool> kNoStop{false};

struct RunResult {
  common::Result<PipelineOutcome> outcome;
  Transcript told;
  std::vector<std::string> laser_calls;
  std::vector<std::string> visual_calls;
};

RunResult run(FakeModule& laser, FakeModule& visual, const PipelineOptions& options,
              std::vector<common::RecordingItem> items, int command_every = 0,
              const std::atomic<bool>& stop = kNoStop) {
  FakeRecording recording(std::move(items));
  FakeFusion fusion(command_every);
  RunResult result;
  result.outcome = run_pipeline({&recording, {{&laser}, {&visual}}, &fusion, &result.told}, options, stop);
  result.laser_calls = laser.calls;
  result.visual_calls = visual.calls;
  return result;
}

RunResult run_with_delays(int threads, unsigned seed, int command_every) {
  FakeModule laser(PoseSource::kLaser, random_delay(seed, 300us));
  FakeModule visual(PoseSource::kVisual, random_delay(seed + 1, 600us));
  PipelineOptions options;
  options.threads = threads;
  options.queue_capacity = 8;
  options.command_delay = 5;
  return run(laser, visual, options, rounds(100), command_every);
}

class PipelineThreads : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(OneAndMany, PipelineThreads, testing::Values(1, 2));

TEST(Pipeline, DoesTheSameWithOneThreadAndWithManyUnderRandomDelays) {
  const RunResult one = run_with_delays(1, 1, 7);
  for (unsigned seed = 2; seed < 6; ++seed) {
    const RunResult many = run_with_delays(2, seed, 7);
    EXPECT_EQ(many.told.lines, one.told.lines);
    EXPECT_EQ(many.laser_calls, one.laser_calls);
    EXPECT_EQ(many.visual_calls, one.visual_calls);
  }
}

TEST_P(PipelineThreads, TellsOutputsInTheOrderOfInputIndexThenSource) {
  FakeModule laser(PoseSource::kLaser, random_delay(1, 1ms));
  FakeModule visual(PoseSource::kVisual);
  PipelineOptions options;
  options.threads = GetParam();
  const RunResult result = run(laser, visual, options, rounds(2));
  const std::vector<std::string> expected{
      "odometry 1000000000", "step 1000000000",     "laser 1010000000 2", "fused 1010000000 2",
      "step 1010000000",     "visual 1020000000 2", "fused 1020000000 2", "step 1020000000",
      "odometry 1030000000", "step 1030000000",     "laser 1040000000 4", "fused 1040000000 4",
      "step 1040000000",     "visual 1050000000 4", "fused 1050000000 4", "step 1050000000"};
  EXPECT_EQ(result.told.lines, expected);
}

TEST_P(PipelineThreads, CarriesOutACommandBeforeTheFirstInputAtItsIndexPlusDelay) {
  FakeModule laser(PoseSource::kLaser);
  FakeModule visual(PoseSource::kVisual);
  PipelineOptions options;
  options.threads = GetParam();
  options.command_delay = 4;
  // The third fusion input is the image at index 2: due before index 6, the odometry of the third round.
  const RunResult result = run(laser, visual, options, rounds(4), 3);
  const auto command = std::find_if(result.laser_calls.begin(), result.laser_calls.end(),
                                    [](const std::string& call) { return call.starts_with("set pose"); });
  ASSERT_NE(command, result.laser_calls.end());
  EXPECT_EQ(*(command - 1), "process 1040000000");
  EXPECT_EQ(*(command + 1), "process 1060000000");
}

TEST_P(PipelineThreads, CarriesACommandedPoseOnByTheOdometryDrivenMeanwhile) {
  FakeModule laser(PoseSource::kLaser);
  FakeModule visual(PoseSource::kVisual);
  PipelineOptions options;
  options.threads = GetParam();
  options.command_delay = 4;
  const RunResult result = run(laser, visual, options, rounds(4), 3);
  // Issued in rounds 0 and 1, carried out at the odometry two rounds of 1 cm later.
  EXPECT_EQ(std::count(result.laser_calls.begin(), result.laser_calls.end(), "set pose 100.020"), 2);
}

TEST_P(PipelineThreads, LosesNothingToASlowModuleInReplay) {
  FakeModule laser(PoseSource::kLaser);
  FakeModule visual(PoseSource::kVisual, [] { std::this_thread::sleep_for(1ms); });
  PipelineOptions options;
  options.threads = GetParam();
  options.queue_capacity = 2;
  const RunResult result = run(laser, visual, options, rounds(60));
  const auto& counters = result.outcome->counters;
  EXPECT_EQ(counters.at(PoseSource::kVisual).inputs, 60U);
  EXPECT_EQ(counters.at(PoseSource::kVisual).poses, 60U);
  EXPECT_EQ(counters.at(PoseSource::kVisual).dropped, 0U);
  EXPECT_EQ(counters.at(PoseSource::kLaser).poses, 60U);
  EXPECT_EQ(counters.at(PoseSource::kFused).inputs, 180U);
  EXPECT_EQ(counters.at(PoseSource::kFused).poses, 120U);
}

TEST_P(PipelineThreads, GoesOnAfterRejectedMessagesAndReportsThemOnceAndAsASum) {
  FakeModule laser(PoseSource::kLaser);
  laser.reject_from = 1'400'000'000;  // scans of the rounds 13 to 19
  FakeModule visual(PoseSource::kVisual);
  auto items = rounds(20);
  for (int i = 0; i < 3; ++i) {
    items.insert(items.begin() + 5,
                 common::RejectedMessage{1'000'000'000 + i, "cam0", fmt::format("cam0/data.csv:{}: cut image", i)});
  }
  PipelineOptions options;
  options.threads = GetParam();
  const RunResult result = run(laser, visual, options, items);
  EXPECT_EQ(result.outcome->counters.at(PoseSource::kLaser).rejected, 7U);
  EXPECT_EQ(result.outcome->counters.at(PoseSource::kLaser).inputs, 20U);
  EXPECT_EQ(result.outcome->counters.at(PoseSource::kVisual).rejected, 3U);
  EXPECT_EQ(result.outcome->counters.at(PoseSource::kVisual).inputs, 23U);
  EXPECT_EQ(result.outcome->counters.at(PoseSource::kVisual).poses, 20U);
  ASSERT_EQ(result.told.events.size(), 4U);  // the first of each kind, then both sums
  EXPECT_EQ(result.told.events[0].detail, "cam0: cam0/data.csv:2: cut image");
  EXPECT_NE(result.told.events[2].detail.find("3 messages"), std::string::npos);
}

TEST_P(PipelineThreads, TurnsAnExceptionOfAModuleIntoAnError) {
  FakeModule laser(PoseSource::kLaser);
  laser.throw_at = 1'310'000'000;
  FakeModule visual(PoseSource::kVisual);
  PipelineOptions options;
  options.threads = GetParam();
  const RunResult result = run(laser, visual, options, rounds(50));
  ASSERT_FALSE(result.outcome.has_value());
  EXPECT_EQ(result.outcome.error().kind, common::ErrorKind::kFailed);
  EXPECT_NE(result.outcome.error().message.find("the fake module threw"), std::string::npos);
}

TEST_P(PipelineThreads, EndsSoonAfterTheStopFlagIsSet) {
  FakeModule laser(PoseSource::kLaser);
  FakeModule visual(PoseSource::kVisual, [] { std::this_thread::sleep_for(10ms); });
  PipelineOptions options;
  options.threads = GetParam();
  std::atomic<bool> stop{false};
  std::jthread stopper([&stop] {
    std::this_thread::sleep_for(100ms);
    stop = true;
  });
  const auto start = std::chrono::steady_clock::now();
  const RunResult result = run(laser, visual, options, rounds(2000), 0, stop);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 1s);
  ASSERT_TRUE(result.outcome.has_value());
  EXPECT_TRUE(result.outcome->interrupted);
  EXPECT_FALSE(result.told.lines.empty());
}

TEST(Pipeline, HoldsAReplayBackToItsRate) {
  FakeModule laser(PoseSource::kLaser);
  FakeModule visual(PoseSource::kVisual);
  PipelineOptions options;
  options.rate = 2.0;
  const auto start = std::chrono::steady_clock::now();
  run(laser, visual, options, rounds(11));  // 0.32 s of recording
  EXPECT_GE(std::chrono::steady_clock::now() - start, 159ms);
}

TEST(Pipeline, LiveASlowModuleLosesImagesAndHoldsNobodyUp) {
  FakeModule laser(PoseSource::kLaser);
  FakeModule visual(PoseSource::kVisual, [] { std::this_thread::sleep_for(10ms); });  // odometry too: 20 ms a round
  PipelineOptions options;
  options.threads = 2;
  options.rate = 3.0;  // 10 ms a round
  options.live_backlog = 2;
  constexpr std::size_t kRounds = 60;
  const RunResult result = run(laser, visual, options, rounds(kRounds));
  ASSERT_TRUE(result.outcome.has_value());
  const auto& counters = result.outcome->counters;
  EXPECT_GT(counters.at(PoseSource::kVisual).dropped, 0u);
  for (const auto source : {PoseSource::kLaser, PoseSource::kVisual}) {
    EXPECT_EQ(counters.at(source).inputs, kRounds);
    EXPECT_EQ(counters.at(source).poses + counters.at(source).dropped, kRounds);
  }
}

// How a live pipeline is built, and what comes in.
struct LiveCase {
  std::string name;
  std::size_t queue_capacity;
  int live_backlog;
  int command_delay;
  std::vector<common::RecordingItem> items;
};

// Few scans among many images, and no odometry that would tell the fusion how far the others are.
std::vector<common::RecordingItem> scans_among_images() {
  std::vector<common::RecordingItem> items;
  for (int i = 0; i < 400; ++i) {
    const common::Nanoseconds stamp = 1'000'000'000LL + i * 1'000'000LL;
    if (i % 10 == 0) items.emplace_back(common::SensorMessage(common::LaserScan{stamp, "laser0", {1.0F}}));
    items.emplace_back(common::SensorMessage(common::Image{stamp, "cam0", 0, 0, nullptr}));
  }
  return items;
}

class LivePipeline : public testing::TestWithParam<LiveCase> {};

INSTANTIATE_TEST_SUITE_P(Capacities, LivePipeline,
                         testing::Values(LiveCase{"SmallBacklog", 8, 5, 16, rounds(100)},
                                         LiveCase{"BacklogFillsTheQueue", 8, 8, 16, rounds(100)},
                                         LiveCase{"BacklogAboveTheQueue", 4, 20, 16, rounds(100)},
                                         LiveCase{"BacklogAboveTheCommandDelay", 64, 500, 2, scans_among_images()}),
                         [](const auto& tested) { return tested.param.name; });

// The odometry and the scans of a second and more come while the visual half is at one image.
TEST_P(LivePipeline, AModuleThatHangsHoldsUpNobody) {
  class Watcher : public PipelineObserver {
   public:
    void on_estimate(const common::PoseEstimate& estimate) override {
      if (estimate.source != PoseSource::kLaser) return;
      last_laser = std::chrono::steady_clock::now();
      newest_laser = estimate.stamp;
    }
    void on_dropped(const std::string& sensor) override { ++dropped[sensor]; }
    std::chrono::steady_clock::time_point last_laser;
    common::Nanoseconds newest_laser = 0;
    std::map<std::string, int> dropped;
  };
  bool first = true;
  FakeModule laser(PoseSource::kLaser);
  FakeModule visual(PoseSource::kVisual, [&first] {
    if (std::exchange(first, false)) std::this_thread::sleep_for(2s);
  });
  FakeRecording recording(GetParam().items);
  FakeFusion fusion(0);
  Watcher watcher;
  PipelineOptions options;
  options.threads = 2;
  options.rate = 10.0;  // of recordings of 0.4 s and 3 s
  options.queue_capacity = GetParam().queue_capacity;
  options.live_backlog = GetParam().live_backlog;
  options.command_delay = GetParam().command_delay;
  const auto start = std::chrono::steady_clock::now();
  const auto outcome = run_pipeline({&recording, {{&laser}, {&visual}}, &fusion, &watcher}, options, kNoStop);
  ASSERT_TRUE(outcome.has_value());
  EXPECT_LT(watcher.last_laser - start, 1s) << "the laser's poses waited for the visual half";
  EXPECT_GT(watcher.newest_laser,
            common::stamp_of(std::get<common::SensorMessage>(GetParam().items.back())) - 100'000'000)
      << "the laser has no poses of the end";
  const auto& counters = outcome->counters;
  EXPECT_EQ(watcher.dropped["laser0"], static_cast<int>(counters.at(PoseSource::kLaser).dropped));
  EXPECT_EQ(watcher.dropped["cam0"], static_cast<int>(counters.at(PoseSource::kVisual).dropped));
  const auto images = std::count_if(GetParam().items.begin(), GetParam().items.end(), [](const auto& item) {
    return std::holds_alternative<common::Image>(std::get<common::SensorMessage>(item));
  });
  EXPECT_EQ(watcher.dropped["cam0"], std::max(0, static_cast<int>(images) - options.live_backlog));
  EXPECT_EQ(watcher.dropped["odom0"], 0);
}

TEST(Pipeline, TellsCheckpointsInTheirIntervals) {
  class Checkpoints : public PipelineObserver {
   public:
    void on_checkpoint(PoseSource source, const std::shared_ptr<const ModuleCheckpoint>& checkpoint) override {
      told.emplace_back(source, checkpoint->laser_state);
    }
    std::vector<std::pair<PoseSource, std::string>> told;
  };
  FakeModule laser(PoseSource::kLaser);
  FakeRecording recording(rounds(11));  // scans at 0, 30, ..., 300 ms
  FakeFusion fusion(0);
  Checkpoints checkpoints;
  PipelineOptions options;
  options.checkpoint_interval = 90'000'000;
  const PipelineModule module{&laser, nullptr, [] { return ModuleCheckpoint{.laser_state = "state"}; }};
  ASSERT_TRUE(run_pipeline({&recording, {module}, &fusion, &checkpoints}, options, kNoStop));
  ASSERT_EQ(checkpoints.told.size(), 3u);
  EXPECT_EQ(checkpoints.told.front(), std::pair(PoseSource::kLaser, std::string("state")));
}

TEST(Pipeline, RunsAnEmptyRecordingWithoutTellingAnything) {
  FakeModule laser(PoseSource::kLaser);
  FakeModule visual(PoseSource::kVisual);
  const RunResult result = run(laser, visual, {}, {});
  ASSERT_TRUE(result.outcome.has_value());
  EXPECT_TRUE(result.told.lines.empty());
}

}  // namespace
}  // namespace slamfuse::service
