// SPDX-License-Identifier: BSD-3-Clause
#include "common/tum.hpp"

#include <fstream>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/temporary_file.hpp"

namespace slamfuse::common {
namespace {

using testing::HasSubstr;

Result<Trajectory3> read_text(const std::string& text) {
  return read_trajectory(TemporaryFile("path.tum", text).path());
}

TEST(ReadTrajectory, ReadsTumLinesSkippingCommentsAndBlankLines) {
  const auto trajectory =
      read_text("# stamp x y z qx qy qz qw\n\n1700000000.005 1 -2 0.5 0 0 0 1\n  # more\n2 0 0 0 0 0 1 0\n");

  ASSERT_TRUE(trajectory.has_value()) << trajectory.error().message;
  ASSERT_EQ(trajectory->size(), 2u);
  EXPECT_EQ(trajectory->at(0).stamp, 1700000000005000000);
  EXPECT_EQ(trajectory->at(0).pose.translation, Eigen::Vector3d(1, -2, 0.5));
  EXPECT_NEAR(to_pose2(trajectory->at(1).pose).theta, std::numbers::pi, 1e-12);
}

TEST(ReadTrajectory, ReadsPlanarLinesWithWrappedHeadings) {
  const auto trajectory = read_text("1538499903.588082075\t0.5 -1e-3 7.0\r\n");

  ASSERT_TRUE(trajectory.has_value()) << trajectory.error().message;
  EXPECT_EQ(trajectory->at(0).stamp, 1538499903588082075);
  const Pose2 pose = to_pose2(trajectory->at(0).pose);
  EXPECT_DOUBLE_EQ(pose.x, 0.5);
  EXPECT_DOUBLE_EQ(pose.y, -1e-3);
  EXPECT_NEAR(pose.theta, 7.0 - 2.0 * std::numbers::pi, 1e-12);
}

TEST(ReadTrajectory, KeepsTheOrderOfTheLinesWhenStampsStepBack) {
  const auto trajectory = read_text("2 0 0 0\n1 1 0 0\n1 2 0 0\n");

  ASSERT_TRUE(trajectory.has_value());
  EXPECT_EQ(trajectory->at(1).stamp, kNanosecondsPerSecond);
  EXPECT_EQ(trajectory->at(2).pose.translation.x(), 2.0);
}

TEST(ReadTrajectory, NormalisesAQuaternionThatIsOnlyRounded) {
  const auto trajectory = read_text("0 0 0 0 0 0 0.7071 0.7071\n");

  ASSERT_TRUE(trajectory.has_value()) << trajectory.error().message;
  EXPECT_NEAR(trajectory->at(0).pose.rotation.norm(), 1.0, 1e-15);
}

struct BadText {
  const char* text;
  const char* message;
};

class ReadTrajectoryRefuses : public testing::TestWithParam<BadText> {};

TEST_P(ReadTrajectoryRefuses, WithLineAndReason) {
  const auto trajectory = read_text(GetParam().text);

  ASSERT_FALSE(trajectory.has_value());
  EXPECT_EQ(trajectory.error().kind, ErrorKind::kInvalidInput);
  EXPECT_THAT(trajectory.error().message, HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Texts, ReadTrajectoryRefuses,
    testing::Values(BadText{"", "path.tum: has no line of numbers"},
                    BadText{"# only a comment\n", "has no line of numbers"},
                    BadText{"1 2 3\n", "path.tum:1: 3 columns, expected 8"},
                    BadText{"1 0 0 0\n2 0 0 0 0 0 0 1\n", "path.tum:2: 8 columns, the lines before have 4"},
                    BadText{"1 0 0 0\n2 0 zero 0\n", "path.tum:2: column 3 is 'zero'"},
                    BadText{"1 0 nan 0\n", "column 3 is 'nan', expected a finite number"},
                    BadText{"1 0 0 inf\n", "column 4 is 'inf'"}, BadText{"1 0 0 1e999\n", "column 4 is '1e999'"},
                    BadText{"1 0 0x1 0\n", "column 3 is '0x1'"}, BadText{"now 0 0 0\n", "column 1 is 'now'"},
                    BadText{"9223372036 0 0 0\n", "column 1 is '9223372036'"},
                    BadText{"1 0 0 0 0 0 0 0\n", "the quaternion's length is 0"},
                    BadText{"1 0 0 0 0 0 0 1.002\n", "the quaternion's length is 1.002"}));

TEST(ReadTrajectory, RefusesALineWithoutEnd) {
  const auto trajectory = read_text("1 0 0 0\n" + std::string((std::size_t{1} << 20) + 1, '1'));

  EXPECT_THAT(trajectory.error().message, HasSubstr("path.tum:2: line longer than 1048576 characters"));
}

TEST(ReadTrajectory, RefusesMissingFilesAndFolders) {
  EXPECT_THAT(read_trajectory("/no/such/path.tum").error().message, HasSubstr("/no/such/path.tum: no such file"));
  EXPECT_THAT(read_trajectory(testing::TempDir()).error().message, HasSubstr("not a regular file"));
}

TEST(ToTum, WritesNineDecimalsAndReadsBackTheSame) {
  const Trajectory2 trajectory = {{1700000000005000000, {1.25, -2.5, 0.0}}, {-1, {1e4 / 3.0, 1e-9, -3.1}}};

  const std::string text = to_tum(trajectory);

  EXPECT_TRUE(
      text.starts_with("1700000000.005000000 1.250000000 -2.500000000 0.000000000 0.000000000000 "
                       "0.000000000000 0.000000000000 1.000000000000\n-0.000000001 "));
  const auto read = read_text(text);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  ASSERT_EQ(read->size(), trajectory.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const Pose2 pose = to_pose2(read->at(i).pose);
    EXPECT_EQ(read->at(i).stamp, trajectory[i].stamp);
    EXPECT_NEAR(pose.x, trajectory[i].pose.x, 1e-9);
    EXPECT_NEAR(pose.y, trajectory[i].pose.y, 1e-9);
    EXPECT_NEAR(pose.theta, trajectory[i].pose.theta, 1e-11);
  }
}

TEST(WriteTum, TellsWhyAFileCannotBeWritten) {
  const Result<void> missing_folder = write_tum("/no/such/folder/path.tum", Trajectory2{});
  ASSERT_FALSE(missing_folder.has_value());
  EXPECT_EQ(missing_folder.error().kind, ErrorKind::kFailed);
  EXPECT_THAT(missing_folder.error().message, HasSubstr("No such file or directory"));

  if (std::filesystem::exists("/dev/full")) {
    const Result<void> disk_full = write_tum("/dev/full", Trajectory2{{0, {}}});
    ASSERT_FALSE(disk_full.has_value());
    EXPECT_THAT(disk_full.error().message, HasSubstr("No space left on device"));
  }
}

}  // namespace
}  // namespace slamfuse::common
