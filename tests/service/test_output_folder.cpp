// SPDX-License-Identifier: BSD-3-Clause
#include "service/output_folder.hpp"

#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "service/durable_file.hpp"
#include "service/map_bundle.hpp"
#include "service/temporary_folder.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

void put_map_bundle(const fs::path& out) {
  fs::create_directories(out);
  MapBundle bundle;
  bundle.laser_state = "state";
  ASSERT_TRUE(write_map_bundle(bundle, out / "map").has_value());
}

/// Expects that the folder cannot be used, that the message names what is in the way, and that it is still there.
void expect_in_the_way(const fs::path& out, ResultKind kind, const std::string& name) {
  const auto folder = OutputFolder::create(out, kind);
  ASSERT_FALSE(folder.has_value());
  EXPECT_EQ(folder.error().kind, common::ErrorKind::kInvalidInput);
  EXPECT_THAT(folder.error().message, HasSubstr((out / name).string() + " is in the way"));
  EXPECT_TRUE(fs::exists(fs::symlink_status(out / name)));
}

TEST(OutputFolder, ShowsNothingBeforeItIsPublished) {
  const TemporaryFolder temporary;
  const auto folder = OutputFolder::create(temporary / "out", ResultKind::kRun);
  ASSERT_TRUE(folder.has_value());
  ASSERT_TRUE((*folder)->write("laser.tum", "1").has_value());
  EXPECT_FALSE(fs::exists(temporary / "out/laser.tum"));
  ASSERT_TRUE((*folder)->publish().has_value());
  EXPECT_EQ(content_of(temporary / "out/laser.tum"), "1");
}

TEST(OutputFolder, LeavesNoTraceWhenItIsNotPublished) {
  const TemporaryFolder temporary;
  {
    const auto folder = OutputFolder::create(temporary / "new/deep/out", ResultKind::kRun);
    ASSERT_TRUE((*folder)->write("laser.tum", "1").has_value());
  }
  EXPECT_THAT(names_in(temporary.path()), IsEmpty());
}

TEST(OutputFolder, LeavesNoTemporaryFilesBehind) {
  const TemporaryFolder temporary;
  {
    const auto folder = OutputFolder::create(temporary / "out", ResultKind::kRun);
    ASSERT_TRUE((*folder)->write("laser.tum", "1").has_value());
    ASSERT_TRUE((*folder)->publish().has_value());
  }
  EXPECT_THAT(names_in(temporary / "out"), ElementsAre("laser.tum"));
}

TEST(OutputFolder, RemovesOlderResultsThatWereNotMadeAgainAndNothingElse) {
  const TemporaryFolder temporary;
  put_map_bundle(temporary / "out");
  put(temporary / "out/visual.tum", "# slamfuse old");
  put(temporary / "out/laser.tum", "# slamfuse old");
  put(temporary / "out/notes.txt", "mine");
  const auto folder = OutputFolder::create(temporary / "out", ResultKind::kRun);
  ASSERT_TRUE((*folder)->write("laser.tum", "new").has_value());
  ASSERT_TRUE((*folder)->publish().has_value());
  EXPECT_EQ(content_of(temporary / "out/laser.tum"), "new");
  EXPECT_EQ(content_of(temporary / "out/notes.txt"), "mine");
  EXPECT_FALSE(fs::exists(temporary / "out/visual.tum"));
  EXPECT_FALSE(fs::exists(temporary / "out/map"));
}

TEST(OutputFolder, ReplacesAnOlderFolderByANewOne) {
  const TemporaryFolder temporary;
  put_map_bundle(temporary / "out");
  const auto folder = OutputFolder::create(temporary / "out", ResultKind::kRun);
  fs::create_directories((*folder)->staging() / "map");
  put((*folder)->staging() / "map/new.bin", "new");
  ASSERT_TRUE((*folder)->publish().has_value());
  EXPECT_THAT(names_in(temporary / "out/map"), ElementsAre("new.bin"));
}

TEST(OutputFolder, RefusesToReplaceAMapFolderThatIsNotAMapBundle) {
  const TemporaryFolder temporary;
  fs::create_directories(temporary / "out/map");
  put(temporary / "out/map/sketch.svg", "mine");
  expect_in_the_way(temporary / "out", ResultKind::kRun, "map/sketch.svg");
}

TEST(OutputFolder, RefusesToReplaceAMapBundleThatHoldsAForeignFile) {
  const TemporaryFolder temporary;
  put_map_bundle(temporary / "out");
  put(temporary / "out/map/notes.txt", "mine");
  expect_in_the_way(temporary / "out", ResultKind::kRun, "map/notes.txt");
}

TEST(OutputFolder, RefusesToReplaceAMapThatIsALink) {
  const TemporaryFolder temporary;
  fs::create_directories(temporary / "elsewhere");
  fs::create_directories(temporary / "out");
  fs::create_directory_symlink(temporary / "elsewhere", temporary / "out/map");
  expect_in_the_way(temporary / "out", ResultKind::kRun, "map");
}

TEST(OutputFolder, RefusesToReplaceAFolderByAFile) {
  const TemporaryFolder temporary;
  fs::create_directories(temporary / "out/report.html");
  expect_in_the_way(temporary / "out", ResultKind::kRun, "report.html");
}

TEST(OutputFolder, RefusesToReplaceATrajectoryOfAnotherProgram) {
  const TemporaryFolder temporary;
  fs::create_directories(temporary / "out");
  put(temporary / "out/laser.tum", "1.0 0 0 0 0 0 0 1\n");
  expect_in_the_way(temporary / "out", ResultKind::kRun, "laser.tum");
}

TEST(OutputFolder, RefusesToMixTheResultsOfTwoCommands) {
  const TemporaryFolder temporary;
  fs::create_directories(temporary / "run");
  put(temporary / "run/fused.tum", "# slamfuse");
  expect_in_the_way(temporary / "run", ResultKind::kAlignment, "fused.tum");
  fs::create_directories(temporary / "alignment");
  put(temporary / "alignment/visual_aligned.tum", "# slamfuse");
  expect_in_the_way(temporary / "alignment", ResultKind::kRun, "visual_aligned.tum");
}

TEST(OutputFolder, LeavesAForeignFileWithAnOrdinaryOldNameAlone) {
  const TemporaryFolder temporary;
  put_map_bundle(temporary / "out");
  put(temporary / "out/map.old", "mine");
  const auto folder = OutputFolder::create(temporary / "out", ResultKind::kRun);
  fs::create_directories((*folder)->staging() / "map");
  ASSERT_TRUE((*folder)->publish().has_value());
  EXPECT_EQ(content_of(temporary / "out/map.old"), "mine");
}

TEST(OutputFolder, DoesNotPublishWhatAKilledProcessOfTheSameNumberLeft) {
  const TemporaryFolder temporary;
  fs::create_directories(temporary / "out" / fmt::format(".slamfuse-{}", ::getpid()));
  put(temporary / "out" / fmt::format(".slamfuse-{}", ::getpid()) / "visual.tum", "stale");
  const auto folder = OutputFolder::create(temporary / "out", ResultKind::kRun);
  ASSERT_TRUE((*folder)->write("laser.tum", "1").has_value());
  ASSERT_TRUE((*folder)->publish().has_value());
  EXPECT_FALSE(fs::exists(temporary / "out/visual.tum"));
}

TEST(OutputFolder, ClearsAwayWhatKilledProcessesLeft) {
  const TemporaryFolder temporary;
  const fs::path dead = temporary / "out/.slamfuse-99999999";  // above every process number
  const fs::path alive = temporary / "out/.slamfuse-1";
  const fs::path foreign = temporary / "out/.slamfuse-notes";
  for (const auto& folder : {dead, alive, foreign}) fs::create_directories(folder);
  ASSERT_TRUE(OutputFolder::create(temporary / "out", ResultKind::kRun));
  EXPECT_FALSE(fs::exists(dead));
  EXPECT_TRUE(fs::exists(alive));
  EXPECT_TRUE(fs::exists(foreign));
}

TEST(OutputFolder, SaysWhyItCannotBeMade) {
  const TemporaryFolder temporary;
  put(temporary / "file", "x");
  const auto folder = OutputFolder::create(temporary / "file/out", ResultKind::kRun);
  ASSERT_FALSE(folder.has_value());
  EXPECT_EQ(folder.error().kind, common::ErrorKind::kInvalidInput);
  EXPECT_THAT(folder.error().message, HasSubstr("Not a directory"));
}

TEST(DurableFile, ReplacesTheContentAsAWhole) {
  const TemporaryFolder temporary;
  put(temporary / "file", "a longer old content");
  ASSERT_TRUE(write_durably(temporary / "file", "new").has_value());
  EXPECT_EQ(content_of(temporary / "file"), "new");
  EXPECT_THAT(names_in(temporary.path()), ElementsAre("file"));
}

TEST(DurableFile, NamesTheFileThatCannotBeWritten) {
  const auto written = write_durably("/dev/full/file", "x");
  ASSERT_FALSE(written.has_value());
  EXPECT_EQ(written.error().kind, common::ErrorKind::kFailed);
  EXPECT_THAT(written.error().message, HasSubstr("/dev/full/file"));
}

}  // namespace
}  // namespace slamfuse::service
