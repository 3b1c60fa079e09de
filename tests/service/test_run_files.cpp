// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_files.hpp"

#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/tum.hpp"
#include "service/metrics.hpp"
#include "service/run_report.hpp"
#include "service/temporary_folder.hpp"

namespace slamfuse::service {
namespace {

using common::PoseSource;
using testing::HasSubstr;

TEST(TrajectoryFile, IsReadBackInSpiteOfItsComment) {
  const TemporaryFolder temporary;
  const common::Trajectory2 trajectory{{1'700'000'000'123'456'789, {1.0, -2.0, 0.5}}};
  put(temporary / "laser.tum", trajectory_file(trajectory, 42));
  const auto read = common::read_trajectory(temporary / "laser.tum");
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(read->front().stamp, trajectory.front().stamp);
}

TEST(TrajectoryFile, SaysTheSeedAndWhetherItIsIncomplete) {
  EXPECT_THAT(trajectory_file({}, 42), HasSubstr("seed 42\n"));
  EXPECT_THAT(trajectory_file({}, 42, true), HasSubstr("seed 42 incomplete\n"));
}

TEST(StatusCsv, KeepsFiveColumnsWhateverTheReasonsSay) {
  const std::vector<fusion::StatusEntry> status{
      {7, PoseSource::kLaser, fusion::Verdict::kSuspect, 0.25, {"a, b", "he said \"no\""}},
      {8, PoseSource::kFused, fusion::Verdict::kTracking, 1.0, {}}};
  EXPECT_EQ(status_csv(status),
            "stamp_ns,source,state,score,reasons\n"
            "7,laser,SUSPECT,0.250,a; b; he said 'no'\n"
            "8,fused,TRACKING,1.000,\n");
}

RunSummary laser_only_summary() {
  RunSummary summary;
  summary.seed = 3;
  summary.recording = "rec";
  summary.duration_s = 10.0;
  summary.wall_s = 4.0;
  summary.counters[PoseSource::kLaser].inputs = 5;
  summary.counters[PoseSource::kLaser].updated({1, 2.0});
  summary.counters[PoseSource::kLaser].updated({2, 4.0});
  summary.counters[PoseSource::kFused].inputs = 9;
  summary.coverage[PoseSource::kLaser] = 0.5;
  summary.log.events.push_back({4, "laser", "lost", "why"});
  return summary;
}

TEST(Metrics, HaveTheKeysOfTheContractInItsOrder) {
  const auto metrics = metrics_of(laser_only_summary());
  std::vector<std::string> keys;
  for (const auto& [key, value] : metrics.items()) keys.push_back(key);
  EXPECT_THAT(keys, testing::ElementsAre("slamfuse", "seed", "recording", "incomplete", "duration_s", "wall_s",
                                         "real_time_factor", "peak_rss_mb", "modules", "accuracy", "events"));
  EXPECT_EQ(metrics["real_time_factor"], 2.5);
  EXPECT_EQ(metrics["modules"]["laser"]["update_ms"]["max"], 4.0);
  EXPECT_EQ(metrics["modules"]["fusion"]["inputs"], 9);
  EXPECT_FALSE(metrics["modules"].contains("visual"));
  EXPECT_EQ(metrics["events"][0]["stamp_ns"], 4);
}

TEST(Metrics, TurnWhatIsNoNumberIntoNull) {
  fusion::Alignment alignment;
  alignment.rmse = std::numeric_limits<double>::quiet_NaN();
  alignment.runner_up_ratio = std::numeric_limits<double>::infinity();
  const auto metrics = alignment_metrics(alignment);
  EXPECT_TRUE(metrics["rmse_m"].is_null());
  EXPECT_TRUE(metrics["runner_up_ratio"].is_null());
  EXPECT_EQ(metrics["verdict"], "refused");
}

TEST(Metrics, SurviveFileNamesThatAreNotUtf8) {
  RunSummary summary = laser_only_summary();
  summary.recording = "odd \xff name";
  EXPECT_THAT(json_text(metrics_of(summary)), HasSubstr("odd "));
}

TEST(RunReport, PutsTheOdometryOnTheFirstLaserPose) {
  RunSummary summary = laser_only_summary();
  summary.trajectories = {{"odometry", {{0, {5.0, 5.0, 0.0}}, {100, {6.0, 5.0, 0.0}}}},
                          {"laser", {{0, {1.0, 0.0, 0.0}}}}};
  summary.log.trajectories[PoseSource::kOdometry] = summary.trajectories[0].trajectory;
  const ReportData report = report_of(summary);
  ASSERT_EQ(report.sources.front().source, PoseSource::kOdometry);
  EXPECT_DOUBLE_EQ(report.sources.front().path.back().pose.x, 2.0);
  EXPECT_DOUBLE_EQ(report.sources.front().path.back().pose.y, 0.0);
}

TEST(RunReport, LeavesOutAVisualPathThatIsNotAligned) {
  RunSummary summary = laser_only_summary();
  summary.counters[PoseSource::kVisual].inputs = 1;
  summary.trajectories = {{"laser", {{0, {}}}}, {"visual", {{0, {}}}}};
  summary.alignment.emplace();
  for (const auto& source : report_of(summary).sources) {
    if (source.source == PoseSource::kVisual) {
      EXPECT_TRUE(source.path.empty());
    }
  }
}

}  // namespace
}  // namespace slamfuse::service
