// SPDX-License-Identifier: BSD-3-Clause
// The run command on the demo recording: files, contract of metrics.json, repeatability.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "service/colmap_reader.hpp"
#include "system/program.hpp"
#include "system/scratch.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<std::string> kTrajectories{"odometry",    "laser",        "visual",     "fused",
                                             "laser_final", "visual_final", "fused_final"};

std::vector<std::string> run_flat(const fs::path& out, const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"run", flat().string(), "-o", out.string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(Run, WritesEveryFileOfTheContractAndNothingElse) {
  const Scratch scratch;
  const Outcome outcome = run_program(run_flat(scratch / "out", {"--to", "8"}));
  ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  EXPECT_THAT(names_in(scratch / "out"),
              ElementsAre("fused.tum", "fused_final.tum", "laser.tum", "laser_final.tum", "map", "metrics.json",
                          "odometry.tum", "report.html", "status.csv", "visual.tum", "visual_final.tum"));
  EXPECT_THAT(names_in(scratch / "out/map"),
              ElementsAre("colmap", "fused.tum", "grid.pgm", "grid.yaml", "landmarks.bin", "landmarks.ply", "laser.tum",
                          "laser_state.bin", "map.yaml", "visual.tum"));
  EXPECT_THAT(names_in(scratch / "out/map/colmap"), ElementsAre("cameras.txt", "images.txt", "points3D.txt"));
  EXPECT_EQ(outcome.err, "") << "quiet in a pipe";
  EXPECT_EQ(read_lines(scratch / "out/status.csv").front(), "stamp_ns,source,state,score,reasons");
  EXPECT_THAT(read_text(scratch / "out/report.html"), HasSubstr("</html>"));
}

TEST(Run, WithholdsTheWheelOdometryFromVisualSlamAndGivesItTheScaleWhenJudged) {
  const Scratch scratch;
  const Outcome outcome = run_program(run_flat(scratch / "out", {"--to", "8", "--visual-odometry", "off"}));
  ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  const auto metrics = read_json(scratch / "out/metrics.json");

  EXPECT_EQ(metrics["modules"]["visual"]["inputs"], metrics["modules"]["visual"]["poses"]) << "images, no odometry";
  EXPECT_GT(metrics["modules"]["visual"]["coverage"], 0.9);
  for (const std::string name : {"visual", "visual_final"}) EXPECT_EQ(metrics["accuracy"][name]["align"], "sim2");
  for (const std::string name : {"odometry", "laser", "fused"}) EXPECT_EQ(metrics["accuracy"][name]["align"], "se2");
  EXPECT_LT(metrics["accuracy"]["visual"]["ate_rmse_m"], 0.1);
}

TEST(Run, WritesMetricsAsTheContractSays) {
  const Scratch scratch;
  ASSERT_EQ(run_program(run_flat(scratch / "out", {"--to", "8", "--seed", "7"})).exit_status, 0);
  const auto metrics = read_json(scratch / "out/metrics.json");

  EXPECT_TRUE(metrics["slamfuse"].is_string());
  EXPECT_EQ(metrics["seed"], 7);
  EXPECT_EQ(metrics["incomplete"], false);
  EXPECT_NEAR(metrics["duration_s"], 8.0, 0.1);
  EXPECT_NEAR(metrics["real_time_factor"].get<double>(),
              metrics["duration_s"].get<double>() / metrics["wall_s"].get<double>(), 1e-9);
  EXPECT_GT(metrics["peak_rss_mb"], 1.0);
  for (const std::string module : {"laser", "visual", "fusion"}) {
    const auto& counters = metrics["modules"][module];
    EXPECT_GT(counters["inputs"], 0) << module;
    EXPECT_GT(counters["poses"], 0) << module;
    EXPECT_EQ(counters["dropped"], 0) << module;
    EXPECT_EQ(counters["rejected"], 0) << module;
    EXPECT_GT(counters["coverage"], 0.9) << module;
    for (const char* key : {"median", "p95", "p99", "max"}) EXPECT_TRUE(counters["update_ms"][key].is_number());
  }
  for (const auto& name : kTrajectories) {
    const auto& row = metrics["accuracy"][name];
    EXPECT_EQ(row["align"], "se2") << name;
    for (const char* key : {"ate_rmse_m", "ate_max_m", "heading_rmse_deg", "coverage"}) {
      EXPECT_TRUE(row[key].is_number()) << name << " " << key;
    }
    EXPECT_TRUE(row.contains("rpe_percent")) << name;
  }
  for (const char* key : {"verdict", "reason", "method", "scale", "rotation_deg", "rmse_m", "heldout_rmse_m", "pairs",
                          "runner_up_ratio"}) {
    EXPECT_TRUE(metrics["alignment"].contains(key)) << key;
  }
  EXPECT_EQ(metrics["alignment"]["scale"].size(), 2U);
  EXPECT_TRUE(metrics["events"].is_array());
}

TEST(Run, GivesTheSameBytesTwiceAndWithOneThreadOrTwo) {
  const Scratch scratch;
  ASSERT_EQ(run_program(run_flat(scratch / "a", {"--to", "12", "--threads", "1"})).exit_status, 0);
  ASSERT_EQ(run_program(run_flat(scratch / "b", {"--to", "12", "--threads", "2"})).exit_status, 0);
  ASSERT_EQ(run_program(run_flat(scratch / "c", {"--to", "12", "--threads", "2"})).exit_status, 0);
  for (const auto& other : {"b", "c"}) {
    for (const auto& name : kTrajectories) {
      EXPECT_EQ(read_text(scratch / other / (name + ".tum")), read_text(scratch / "a" / (name + ".tum"))) << name;
    }
    EXPECT_EQ(read_text(scratch / other / "status.csv"), read_text(scratch / "a" / "status.csv"));
    for (const auto& name : names_in(scratch / "a" / "map")) {
      if (fs::is_directory(scratch / "a" / "map" / name)) continue;
      EXPECT_EQ(read_text(scratch / other / "map" / name), read_text(scratch / "a" / "map" / name)) << name;
    }
  }
}

TEST(Run, ExportsAModelWhosePointsLieWhereTheImagesShowThem) {
  const Scratch scratch;
  ASSERT_EQ(run_program(run_flat(scratch / "out", {"--to", "12", "--modules", "visual"})).exit_status, 0);
  const fs::path folder = scratch / "out/map/colmap";
  const service::ColmapReader model(read_text(folder / "cameras.txt"), read_text(folder / "images.txt"),
                                    read_text(folder / "points3D.txt"));
  std::vector<double> errors = model.reprojection_errors();

  EXPECT_EQ(model.cameras.size(), 2U);
  EXPECT_GE(model.images.size(), 8U);
  ASSERT_GT(errors.size(), 200U);
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  EXPECT_LT(errors[errors.size() / 2], 2.0) << "pixels";
  const auto ply = read_lines(scratch / "out/map/landmarks.ply");
  EXPECT_THAT(ply, testing::Contains("element vertex " + std::to_string(model.points.size())));
}

TEST(Run, SaysTheSeedInEveryTrajectoryFile) {
  const Scratch scratch;
  ASSERT_EQ(run_program(run_flat(scratch / "out", {"--to", "2", "--seed", "42"})).exit_status, 0);
  for (const auto& name : kTrajectories) {
    EXPECT_THAT(read_lines(scratch / "out" / (name + ".tum")).front(), HasSubstr("seed 42")) << name;
  }
}

TEST(Run, ReplacesOlderResultsAndLeavesOtherFilesAlone) {
  const Scratch scratch;
  ASSERT_EQ(run_program(run_flat(scratch / "out", {"--to", "2"})).exit_status, 0);
  write_text(scratch / "out/notes.txt", "mine");
  ASSERT_EQ(run_program(run_flat(scratch / "out", {"--to", "3", "--modules", "laser"})).exit_status, 0);
  EXPECT_THAT(names_in(scratch / "out"),
              ElementsAre("fused.tum", "fused_final.tum", "laser.tum", "laser_final.tum", "map", "metrics.json",
                          "notes.txt", "odometry.tum", "report.html", "status.csv"));
  EXPECT_FALSE(fs::exists(scratch / "out/map/landmarks.bin"));
  EXPECT_FALSE(read_json(scratch / "out/metrics.json")["modules"].contains("visual"));
}

TEST(Run, UsesOnlyTheCamerasAskedFor) {
  const Scratch scratch;
  ASSERT_EQ(
      run_program(run_flat(scratch / "out", {"--to", "4", "--modules", "visual", "--cameras", "cam1"})).exit_status, 0);
  const auto metrics = read_json(scratch / "out/metrics.json");
  EXPECT_EQ(metrics["modules"]["visual"]["inputs"], 20);
  EXPECT_FALSE(fs::exists(scratch / "out/laser.tum"));
}

TEST(Run, DoesNotCountTheImagesOfACameraThatIsNotUsed) {
  const Scratch scratch;
  copy_beginning_of_flat(scratch / "flat", 3.0);
  for (const auto& image : fs::directory_iterator(scratch / "flat/cam0/data")) write_text(image.path(), "broken");
  ASSERT_EQ(run_program({"run", (scratch / "flat").string(), "-o", (scratch / "out").string(), "--cameras", "cam1"})
                .exit_status,
            0);
  const auto visual = read_json(scratch / "out/metrics.json")["modules"]["visual"];
  EXPECT_EQ(visual["inputs"], 15);
  EXPECT_EQ(visual["rejected"], 0);
}

TEST(Run, FollowsTheVisualHalfFromItsFirstPoseWithoutALaser) {
  const Scratch scratch;
  ASSERT_EQ(run_program(run_flat(scratch / "out", {"--to", "3", "--modules", "visual"})).exit_status, 0);
  EXPECT_GT(read_json(scratch / "out/metrics.json")["modules"]["fusion"]["coverage"], 0.95);
}

TEST(Run, CutsTheRecordingAtTheTimesAskedFor) {
  const Scratch scratch;
  ASSERT_EQ(run_program(run_flat(scratch / "out", {"--from", "20", "--to", "23"})).exit_status, 0);
  const auto lines = read_lines(scratch / "out/odometry.tum");
  EXPECT_THAT(lines[1], testing::StartsWith("1700000020."));
  EXPECT_THAT(lines.back(), testing::StartsWith("170000002"));
  EXPECT_NEAR(read_json(scratch / "out/metrics.json")["duration_s"], 3.0, 0.1);
}

TEST(Run, DeliversADelayedCameraCompletely) {
  const Scratch scratch;
  ASSERT_EQ(run_program(run_flat(scratch / "out", {"--to", "6", "--arrival-delay", "cam0=0.2"})).exit_status, 0);
  EXPECT_GE(read_json(scratch / "out/metrics.json")["modules"]["visual"]["inputs"], 58);
}

TEST(Run, ContinuesTheLaserMapOfAnEarlierRun) {
  const Scratch scratch;
  ASSERT_EQ(run_program(run_flat(scratch / "first", {"--to", "6", "--modules", "laser"})).exit_status, 0);
  const Outcome second = run_program(run_flat(scratch / "second", {"--from", "6", "--to", "9", "--modules", "laser",
                                                                   "--map", (scratch / "first/map").string()}));
  ASSERT_EQ(second.exit_status, 0) << second.err;
  const auto first_end = read_lines(scratch / "first/laser.tum").back();
  const auto second_start = read_lines(scratch / "second/laser.tum")[1];
  const double end_x = std::stod(first_end.substr(first_end.find(' ')));
  const double start_x = std::stod(second_start.substr(second_start.find(' ')));
  EXPECT_NEAR(start_x, end_x, 0.1);
}

}  // namespace
}  // namespace slamfuse::system
