// SPDX-License-Identifier: BSD-3-Clause
// Input of the wrong structure: refused with a clear message and exit status, nothing written (DESIGN section 2).
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>

#include "system/program.hpp"
#include "system/scratch.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;
constexpr int kInvalidInput = 3;

/// Runs `recording` into a fresh folder and expects the refusal, and that no output folder was left.
void expect_refused(const std::string& recording, const std::vector<std::string>& more, int status,
                    const std::vector<std::string>& words) {
  const Scratch scratch;
  std::vector<std::string> arguments{"run", recording, "-o", (scratch / "out").string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const Outcome outcome = run_program(arguments);
  EXPECT_EQ(outcome.exit_status, status) << outcome.err;
  for (const auto& word : words) EXPECT_THAT(outcome.err, HasSubstr(word));
  EXPECT_FALSE(fs::exists(scratch / "out"));
}

TEST(RefusedInput, MissingFolder) {
  expect_refused("/nowhere/recording", {}, kInvalidInput, {"/nowhere/recording", "no such file or folder"});
}

TEST(RefusedInput, EmptyRecording) {
  const Scratch scratch;
  fs::create_directories(scratch / "empty");
  expect_refused((scratch / "empty").string(), {}, kInvalidInput, {"empty"});
}

TEST(RefusedInput, RecordingWithoutAMessage) {
  const Scratch scratch;
  copy_beginning_of_flat(scratch / "flat", 0.5);
  for (const char* sensor : {"cam0", "cam1", "laser0", "odom0", "state_groundtruth_estimate0"}) {
    write_text(scratch / "flat" / sensor / "data.csv", "#timestamp [ns]\n");
  }
  expect_refused((scratch / "flat").string(), {}, kInvalidInput, {"flat"});
}

TEST(RefusedInput, SensorsWithoutCommonTime) {
  const Scratch scratch;
  copy_beginning_of_flat(scratch / "flat", 1.0);
  auto lines = read_lines(scratch / "flat/laser0/data.csv");
  for (std::size_t i = 1; i < lines.size(); ++i) lines[i].replace(0, 10, "1800000000");
  write_lines(scratch / "flat/laser0/data.csv", lines);
  expect_refused((scratch / "flat").string(), {}, kInvalidInput, {"laser0", "common"});
}

TEST(RefusedInput, UnknownKeyInTheConfiguration) {
  const Scratch scratch;
  write_text(scratch / "robot.yaml", "laser:\n  particels: 50\n");
  expect_refused(flat().string(), {"--config", (scratch / "robot.yaml").string()}, kInvalidInput,
                 {"robot.yaml:2", "particels", "particles"});
}

TEST(RefusedInput, ConfigurationValueOutOfRange) {
  const Scratch scratch;
  write_text(scratch / "robot.yaml", "laser:\n  particles: 0\n");
  expect_refused(flat().string(), {"--config", (scratch / "robot.yaml").string()}, kInvalidInput,
                 {"robot.yaml:2", "particles", "0", "1 to 1000"});
}

TEST(RefusedInput, SettingOutOfRangeOnTheCommandLine) {
  expect_refused(flat().string(), {"--set", "laser.particles=0"}, kWrongUsage, {"laser.particles", "1 to 1000"});
}

TEST(RefusedInput, WrongUsage) {
  expect_refused(flat().string(), {"--threads", "0"}, kWrongUsage, {"--threads"});
  expect_refused(flat().string(), {"--seed", "-1"}, kWrongUsage, {"--seed"});
  expect_refused(flat().string(), {"--from", "nan"}, kWrongUsage, {"--from"});
  expect_refused(flat().string(), {"--from", "5", "--to", "4"}, kWrongUsage, {"--from"});
  expect_refused(flat().string(), {"--from", "1000"}, kWrongUsage, {"--from"});
  expect_refused(flat().string(), {"--modules", "sonar"}, kWrongUsage, {"sonar", "laser"});
  expect_refused(flat().string(), {"--cameras", "cam9"}, kWrongUsage, {"cam9", "cam0, cam1"});
  expect_refused(flat().string(), {"--arrival-delay", "cam9=1"}, kWrongUsage, {"cam9", "cam0"});
  expect_refused(flat().string(), {"--stamp-offset", "cam0"}, kWrongUsage, {"SENSOR=SECONDS"});
  expect_refused(flat().string(), {"--mode", "localization"}, kWrongUsage, {"--mode localization", "--map"});
  expect_refused(flat().string(), {"--visual-odometry", "maybe"}, kWrongUsage, {"--visual-odometry", "maybe"});
  expect_refused(flat().string(), {"--no-such-flag"}, kWrongUsage, {"--no-such-flag"});
}

TEST(RefusedInput, OutputFolderThatCannotBeMade) {
  const Scratch scratch;
  write_text(scratch / "file", "not a folder");
  const Outcome outcome = run_program({"run", flat().string(), "-o", (scratch / "file/out").string()});
  EXPECT_EQ(outcome.exit_status, kInvalidInput);
  EXPECT_THAT(outcome.err, HasSubstr("file/out cannot be written to"));
  EXPECT_EQ(read_text(scratch / "file"), "not a folder");
}

TEST(RefusedInput, OutputFolderThatIsNotWritable) {
  const Outcome outcome = run_program({"run", flat().string(), "-o", "/proc/self"});
  EXPECT_EQ(outcome.exit_status, kInvalidInput);
  EXPECT_THAT(outcome.err, HasSubstr("cannot be written to"));
}

TEST(RefusedInput, OutputFolderThatIsTheRecording) {
  const Scratch scratch;
  copy_beginning_of_flat(scratch / "flat", 1.0);
  const auto before = names_in(scratch / "flat");
  const std::string recording = (scratch / "flat").string();
  const Outcome outcome = run_program({"run", recording, "-o", recording});
  EXPECT_EQ(outcome.exit_status, kInvalidInput);
  EXPECT_THAT(outcome.err, HasSubstr("must not be the recording"));
  EXPECT_EQ(names_in(scratch / "flat"), before);
}

TEST(RefusedInput, UnknownCameraThoughTheVisualHalfDoesNotRun) {
  expect_refused(flat().string(), {"--modules", "laser", "--cameras", "cam7"}, kWrongUsage, {"cam7", "cam0, cam1"});
}

TEST(RefusedInput, AlignmentIntoTheFolderOfARunKeepsTheRun) {
  const Scratch scratch;
  const fs::path out = scratch / "out";
  ASSERT_EQ(run_program({"run", flat().string(), "-o", out.string(), "--to", "2"}).exit_status, 0);
  const auto names = names_in(out);
  const std::string metrics = read_text(out / "metrics.json");
  const Outcome outcome =
      run_program({"align", (out / "laser.tum").string(), (out / "visual.tum").string(), "-o", out.string()});
  EXPECT_EQ(outcome.exit_status, kInvalidInput);
  EXPECT_EQ(names_in(out), names);
  EXPECT_EQ(read_text(out / "metrics.json"), metrics);
}

TEST(RefusedInput, DiskFullWhileWritingTheMapLeavesNothingBehind) {
  const Scratch scratch;
  // Large enough for the trajectories of four seconds, too small for the laser map.
  const Launch launch{{"run", flat().string(), "-o", (scratch / "out").string(), "--to", "4"}, 30'000, {}};
  const Outcome outcome = run_program(launch);
  EXPECT_EQ(outcome.exit_status, kFailed);
  EXPECT_THAT(outcome.err, HasSubstr("/map"));
  EXPECT_THAT(outcome.err, HasSubstr("File too large"));
  EXPECT_FALSE(fs::exists(scratch / "out"));
}

TEST(RefusedInput, DiskFullKeepsTheOlderResults) {
  const Scratch scratch;
  const std::vector<std::string> arguments{"run", flat().string(), "-o", (scratch / "out").string(), "--to", "4"};
  ASSERT_EQ(run_program(arguments).exit_status, 0);
  const auto names = names_in(scratch / "out");
  const auto map = read_text(scratch / "out/map/map.yaml");
  EXPECT_EQ(run_program(Launch{arguments, 30'000, {}}).exit_status, kFailed);
  EXPECT_EQ(names_in(scratch / "out"), names);
  EXPECT_EQ(read_text(scratch / "out/map/map.yaml"), map);
}

TEST(RefusedInput, DiskThatIsReallyFull) {
  const Scratch scratch;
  fs::create_directories(scratch / "disk");
  const std::string disk = (scratch / "disk").string();
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=200k") != 0) GTEST_SKIP() << "mounting needs root";
  const Outcome outcome = run_program({"run", flat().string(), "-o", disk + "/out", "--to", "4"});
  const auto left = names_in(disk);
  ::umount(disk.c_str());
  EXPECT_EQ(outcome.exit_status, kFailed);
  EXPECT_THAT(outcome.err, HasSubstr("No space left on device"));
  EXPECT_THAT(left, IsEmpty());
}

TEST(RefusedInput, DamagedMap) {
  const Scratch scratch;
  ASSERT_EQ(run_program({"run", flat().string(), "-o", (scratch / "out").string(), "--to", "3"}).exit_status, 0);
  const std::string state = read_text(scratch / "out/map/laser_state.bin");
  write_text(scratch / "out/map/laser_state.bin", state.substr(0, state.size() / 2));
  expect_refused(flat().string(), {"--to", "3", "--map", (scratch / "out/map").string()}, kInvalidInput,
                 {"laser_state.bin", "cut"});
}

TEST(RefusedInput, NeitherCommandNorFileLeavesATrace) {
  EXPECT_EQ(run_program(std::vector<std::string>{}).exit_status, kWrongUsage);
  EXPECT_EQ(run_program({"frobnicate"}).exit_status, kWrongUsage);
  EXPECT_EQ(run_program({"run", flat().string()}).exit_status, kWrongUsage);
  EXPECT_EQ(run_program({"info", "/nowhere"}).exit_status, kInvalidInput);
}

}  // namespace
}  // namespace slamfuse::system
