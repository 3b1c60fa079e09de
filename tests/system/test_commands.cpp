// SPDX-License-Identifier: BSD-3-Clause
// The other commands: align, evaluate, info, options.
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "system/program.hpp"
#include "system/scratch.hpp"

namespace slamfuse::system {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A winding path as `t x y theta`, seen through a similarity.
std::string winding_path(double scale, double angle) {
  std::string text;
  for (int i = 0; i < 400; ++i) {
    const double s = 0.05 * i;
    const double x = s + 0.5 * std::sin(1.7 * s);
    const double y = 3.0 * std::sin(0.4 * s);
    const double heading = std::atan2(1.2 * std::cos(0.4 * s), 1.0 + 0.85 * std::cos(1.7 * s));
    const double c = std::cos(angle);
    const double n = std::sin(angle);
    text += fmt::format("{:.3f} {} {} {}\n", 100.0 + 0.1 * i, scale * (c * x - n * y), scale * (n * x + c * y),
                        std::remainder(heading + angle, 6.283185307179586));
  }
  return text;
}

TEST(Align, FindsTheMapBetweenTwoTrajectories) {
  const Scratch scratch;
  write_text(scratch / "laser.tum", winding_path(1.0, 0.0));
  write_text(scratch / "visual.tum", winding_path(4.0, -0.5));
  const Outcome outcome = run_program({"align", (scratch / "laser.tum").string(), (scratch / "visual.tum").string(),
                                       "-o", (scratch / "out").string(), "--method", "similarity"});
  ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  const auto alignment = read_json(scratch / "out/metrics.json")["alignment"];
  EXPECT_EQ(alignment["verdict"], "accepted");
  EXPECT_EQ(alignment["method"], "similarity");
  EXPECT_NEAR(alignment["scale"][0], 0.25, 1e-4);
  EXPECT_NEAR(alignment["rotation_deg"], 0.5 * 180.0 / M_PI, 0.01);
  EXPECT_THAT(names_in(scratch / "out"), ElementsAre("metrics.json", "trajectories.svg", "visual_aligned.tum"));
  EXPECT_EQ(read_lines(scratch / "out/visual_aligned.tum").size(), 401U);
}

TEST(Align, RefusesAStraightPathWithTheReason) {
  const Scratch scratch;
  std::string straight;
  for (int i = 0; i < 200; ++i) straight += fmt::format("{:.1f} {} 0 0\n", 100.0 + 0.1 * i, 0.05 * i);
  write_text(scratch / "path.tum", straight);
  const Outcome outcome = run_program(
      {"align", (scratch / "path.tum").string(), (scratch / "path.tum").string(), "-o", (scratch / "out").string()});
  EXPECT_EQ(outcome.exit_status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("straight"));
  EXPECT_EQ(read_json(scratch / "out/metrics.json")["alignment"]["verdict"], "refused");
}

TEST(Evaluate, ComparesWithTheTruthOfARecording) {
  const Scratch scratch;
  ASSERT_EQ(run_program({"run", flat().string(), "-o", (scratch / "out").string(), "--to", "8"}).exit_status, 0);
  const std::string laser = (scratch / "out/laser.tum").string();
  const Outcome table = run_program({"evaluate", laser, flat().string()});
  ASSERT_EQ(table.exit_status, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("ATE rmse"));
  const auto json = nlohmann::json::parse(run_program({"evaluate", laser, flat().string(), "--json"}).out);
  EXPECT_NEAR(json["ate_rmse_m"], read_json(scratch / "out/metrics.json")["accuracy"]["laser"]["ate_rmse_m"], 2e-3);
}

TEST(Evaluate, AppliesTheTransformFittedOnAnotherPair) {
  const Scratch scratch;
  write_text(scratch / "reference.tum", winding_path(1.0, 0.0));
  write_text(scratch / "turned.tum", winding_path(1.0, 0.7));
  const std::string reference = (scratch / "reference.tum").string();
  const std::string turned = (scratch / "turned.tum").string();
  const auto as = nlohmann::json::parse(
      run_program({"evaluate", turned, reference, "--align-as", turned, reference, "--json"}).out);
  EXPECT_EQ(as["align"], "as");
  EXPECT_NEAR(as["ate_rmse_m"], 0.0, 1e-6);
  const auto none =
      nlohmann::json::parse(run_program({"evaluate", turned, reference, "--align", "none", "--json"}).out);
  EXPECT_GT(none["ate_rmse_m"], 1.0);
}

TEST(Evaluate, MeasuresRelationsWithoutAReference) {
  const Scratch scratch;
  write_text(scratch / "path.tum", "1 0 0 0\n2 1 0 0\n3 2 0 0\n");
  write_text(scratch / "truth.relations", "1 2 1.1 0 0 0 0 0\n1 3 2 0 0 0 0 0\n");
  const Outcome outcome = run_program(
      {"evaluate", (scratch / "path.tum").string(), "--relations", (scratch / "truth.relations").string(), "--json"});
  ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["relations"]["all"]["matched"], 2);
  EXPECT_NEAR(json["relations"]["all"]["translation_m"]["mean"], 0.05, 1e-9);
}

TEST(Evaluate, RefusesTrajectoriesWithNothingInCommon) {
  const Scratch scratch;
  write_text(scratch / "a.tum", "1 0 0 0\n2 1 0 0\n3 2 1 0\n");
  write_text(scratch / "b.tum", "101 0 0 0\n102 1 0 0\n103 2 1 0\n");
  EXPECT_EQ(run_program({"evaluate", (scratch / "a.tum").string(), (scratch / "b.tum").string()}).exit_status, 3);
}

TEST(Info, DescribesARecording) {
  const Outcome outcome = run_program({"info", flat().string()});
  ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("laser0"));
  EXPECT_THAT(outcome.out, HasSubstr("ground truth"));
}

TEST(Info, ChecksAMapAndRefusesADamagedOne) {
  const Scratch scratch;
  ASSERT_EQ(run_program({"run", flat().string(), "-o", (scratch / "out").string(), "--to", "3"}).exit_status, 0);
  const std::string map = (scratch / "out/map").string();
  EXPECT_THAT(run_program({"info", map}).out, HasSubstr("intact"));
  std::string grid = read_text(scratch / "out/map/grid.pgm");
  grid.back() = static_cast<char>(grid.back() ^ 1);
  write_text(scratch / "out/map/grid.pgm", grid);
  const Outcome outcome = run_program({"info", map});
  EXPECT_EQ(outcome.exit_status, 3);
  EXPECT_THAT(outcome.err, HasSubstr("grid.pgm"));
}

TEST(Options, PrintsAFileThatCanBeReadBack) {
  const Scratch scratch;
  const Outcome first = run_program({"options", "--set", "laser.particles=17"});
  ASSERT_EQ(first.exit_status, 0) << first.err;
  write_text(scratch / "robot.yaml", first.out);
  const Outcome second = run_program({"options", "--config", (scratch / "robot.yaml").string()});
  EXPECT_EQ(second.out, first.out);
  EXPECT_THAT(second.out, HasSubstr("particles: 17"));
}

TEST(Options, AreTheDefaultProfile) {
  EXPECT_EQ(run_program({"options"}).out, read_text(std::string(SLAMFUSE_CONFIG_DIR) + "/default.yaml"))
      << "write it anew: slamfuse options > config/default.yaml";
}

TEST(Help, IsThereForEveryCommand) {
  EXPECT_EQ(run_program({"--help"}).exit_status, 0);
  for (const char* command : {"run", "align", "evaluate", "info", "options"}) {
    const Outcome outcome = run_program({command, "--help"});
    EXPECT_EQ(outcome.exit_status, 0);
    EXPECT_THAT(outcome.out, HasSubstr(command));
  }
  EXPECT_THAT(run_program({"--version"}).out, testing::StartsWith("slamfuse "));
}

}  // namespace
}  // namespace slamfuse::system
