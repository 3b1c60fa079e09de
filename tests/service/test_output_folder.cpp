// SPDX-License-Identifier: BSD-3-Clause
#include "service/output_folder.hpp"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "service/durable_file.hpp"
#include "service/temporary_folder.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(OutputFolder, ShowsNothingBeforeItIsPublished) {
  const TemporaryFolder temporary;
  const auto folder = OutputFolder::create(temporary / "out");
  ASSERT_TRUE(folder.has_value());
  ASSERT_TRUE((*folder)->write("laser.tum", "1").has_value());
  EXPECT_FALSE(fs::exists(temporary / "out/laser.tum"));
  ASSERT_TRUE((*folder)->publish().has_value());
  EXPECT_EQ(content_of(temporary / "out/laser.tum"), "1");
}

TEST(OutputFolder, LeavesNoTraceWhenItIsNotPublished) {
  const TemporaryFolder temporary;
  {
    const auto folder = OutputFolder::create(temporary / "new/deep/out");
    ASSERT_TRUE((*folder)->write("laser.tum", "1").has_value());
  }
  EXPECT_THAT(names_in(temporary.path()), IsEmpty());
}

TEST(OutputFolder, LeavesNoTemporaryFilesBehind) {
  const TemporaryFolder temporary;
  {
    const auto folder = OutputFolder::create(temporary / "out");
    ASSERT_TRUE((*folder)->write("laser.tum", "1").has_value());
    ASSERT_TRUE((*folder)->publish().has_value());
  }
  EXPECT_THAT(names_in(temporary / "out"), ElementsAre("laser.tum"));
}

TEST(OutputFolder, RemovesOlderResultsThatWereNotMadeAgainAndNothingElse) {
  const TemporaryFolder temporary;
  fs::create_directories(temporary / "out/map");
  put(temporary / "out/map/grid.pgm", "old");
  put(temporary / "out/visual.tum", "old");
  put(temporary / "out/laser.tum", "old");
  put(temporary / "out/notes.txt", "mine");
  const auto folder = OutputFolder::create(temporary / "out");
  ASSERT_TRUE((*folder)->write("laser.tum", "new").has_value());
  ASSERT_TRUE((*folder)->publish().has_value());
  EXPECT_EQ(content_of(temporary / "out/laser.tum"), "new");
  EXPECT_EQ(content_of(temporary / "out/notes.txt"), "mine");
  EXPECT_FALSE(fs::exists(temporary / "out/visual.tum"));
  EXPECT_FALSE(fs::exists(temporary / "out/map"));
}

TEST(OutputFolder, ReplacesAnOlderFolderByANewOne) {
  const TemporaryFolder temporary;
  fs::create_directories(temporary / "out/map");
  put(temporary / "out/map/old.bin", "old");
  const auto folder = OutputFolder::create(temporary / "out");
  fs::create_directories((*folder)->staging() / "map");
  put((*folder)->staging() / "map/new.bin", "new");
  ASSERT_TRUE((*folder)->publish().has_value());
  EXPECT_THAT(names_in(temporary / "out/map"), ElementsAre("new.bin"));
}

TEST(OutputFolder, SaysWhyItCannotBeMade) {
  const TemporaryFolder temporary;
  put(temporary / "file", "x");
  const auto folder = OutputFolder::create(temporary / "file/out");
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
