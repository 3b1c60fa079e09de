// SPDX-License-Identifier: BSD-3-Clause
#include "common/carmen_recording.hpp"

#include <bzlib.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "common/angle.hpp"
#include "common/recording_samples.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::common {
namespace {

using namespace samples;
using ::testing::HasSubstr;

const std::string kHead = "# CARMEN Logfile\nPARAM robot_frontlaser_offset 0.3 1.0 host 0\n";

std::string flaser(const std::vector<std::string>& ranges, const std::string& laser, const std::string& robot,
                   const std::string& stamp) {
  std::string line = "FLASER " + std::to_string(ranges.size());
  for (const std::string& range : ranges) line += " " + range;
  return line + " " + laser + " " + robot + " " + stamp + " host 0.1\n";
}

/// A scan of `count` readings of 2 m with base_link at (x, 0, 0) and the laser 0.2 m before it.
std::string simple_flaser(int count, double x, const std::string& stamp) {
  return flaser(std::vector<std::string>(static_cast<std::size_t>(count), "2.00"), std::to_string(x + 0.2) + " 0 0",
                std::to_string(x) + " 0 0", stamp);
}

class CarmenRecordingTest : public ::testing::Test {
 protected:
  Contents read(const std::string& text) {
    write_file(file_, text);
    return open_and_read_all(file_);
  }
  LaserCalibration calibration(const std::string& text) {
    write_file(file_, text);
    const auto recording = open_recording(file_);
    EXPECT_TRUE(recording) << recording.error().message;
    return recording ? (*recording)->info().calibration.lasers.at("laser0") : LaserCalibration{};
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "sample.clf";
};

TEST_F(CarmenRecordingTest, GivesOdometryAndScanOfOneStampFromEachFlaser) {
  const Contents contents = read(kHead + "ODOM 9 9 9 0 0 0 0.9 host 0\n" +
                                 flaser({"1.25", "0.00", "81.83"}, "1.3 2.0 0.5", "1.0 2.0 0.5", "976052857.337530"));

  ASSERT_EQ(contents.messages.size(), 2U);
  const auto& odometry = std::get<WheelOdometry>(contents.messages[0]);
  const auto& scan = std::get<LaserScan>(contents.messages[1]);
  EXPECT_EQ(odometry.stamp, 976052857337530000);
  EXPECT_EQ(scan.stamp, odometry.stamp);
  EXPECT_DOUBLE_EQ(odometry.pose.x, 1.0);
  EXPECT_DOUBLE_EQ(odometry.pose.theta, 0.5);
  ASSERT_EQ(scan.ranges.size(), 3U);
  EXPECT_FLOAT_EQ(scan.ranges[0], 1.25F);
  EXPECT_TRUE(std::isnan(scan.ranges[1]));
  EXPECT_TRUE(std::isinf(scan.ranges[2]));
}

TEST_F(CarmenRecordingTest, TakesTheMountingFromLaserAndRobotPose) {
  const std::string turned = flaser({"1", "1"}, "1.0 2.5 1.5707963", "1.0 2.0 1.5707963", "1.0");

  const LaserCalibration laser = calibration(kHead + turned + turned);

  EXPECT_NEAR(laser.T_base_laser.translation.x(), 0.5, 1e-6);
  EXPECT_NEAR(laser.T_base_laser.translation.y(), 0.0, 1e-6);
}

TEST_F(CarmenRecordingTest, TakesTheParameterWhenTheLaserPoseIsACorrectedOne) {
  const LaserCalibration laser = calibration(kHead + flaser({"1", "1"}, "0 0 0", "0 0 0", "1.0") +
                                             flaser({"1", "1"}, "1.5 0.4 0.1", "1.0 0 0", "2.0"));

  EXPECT_DOUBLE_EQ(laser.T_base_laser.translation.x(), 0.3);
}

TEST_F(CarmenRecordingTest, KnowsTheAnglesOfSickScans) {
  const std::array<std::pair<int, double>, 5> cases{{{180, 1.0}, {181, 1.0}, {360, 0.5}, {361, 0.5}, {91, 2.0}}};
  for (const auto& [beams, degrees] : cases) {
    const LaserCalibration laser = calibration(kHead + simple_flaser(beams, 0, "1.0"));
    EXPECT_EQ(laser.beams, beams);
    EXPECT_NEAR(laser.angle_min, -std::numbers::pi / 2, 1e-12);
    EXPECT_NEAR(laser.angle_increment, to_radians(degrees), 1e-12) << beams;
  }
}

TEST_F(CarmenRecordingTest, TakesTheMaximumRangeFromItsParameter) {
  EXPECT_DOUBLE_EQ(calibration(kHead + simple_flaser(2, 0, "1.0")).range_max, 50.0);
  EXPECT_DOUBLE_EQ(calibration("PARAM robot_front_laser_max 8.1 1.0 host 0\n" + simple_flaser(2, 0, "1.0")).range_max,
                   8.1);
}

TEST_F(CarmenRecordingTest, ReadsRobotLaser1WithItsOwnGeometryAndSpeed) {
  const std::string line =
      "ROBOTLASER1 0 -1.2 2.4 1.2 10.0 0.01 0 3 1.5 10.0 3.5 2 7 8 1.1 2.0 0.0 1.0 2.0 0.0 0.4 0.1 0.2 0.3 0.0 12.5 "
      "host "
      "0.7\n";

  const Contents contents = read(line);
  const LaserCalibration laser = calibration(line);

  ASSERT_EQ(contents.messages.size(), 2U);
  const auto& odometry = std::get<WheelOdometry>(contents.messages[0]);
  EXPECT_DOUBLE_EQ(odometry.forward_speed, 0.4);
  EXPECT_DOUBLE_EQ(odometry.turn_rate, 0.1);
  EXPECT_EQ(odometry.stamp, 12'500'000'000);
  EXPECT_TRUE(std::isinf(std::get<LaserScan>(contents.messages[1]).ranges[1]));
  EXPECT_DOUBLE_EQ(laser.angle_min, -1.2);
  EXPECT_DOUBLE_EQ(laser.angle_increment, 1.2);
  EXPECT_DOUBLE_EQ(laser.range_max, 10.0);
  EXPECT_NEAR(laser.T_base_laser.translation.x(), 0.1, 1e-12);
}

TEST_F(CarmenRecordingTest, PrefersRobotLaser1WhereALogHasBoth) {
  const Contents contents = read(simple_flaser(2, 0, "1.0") +
                                 "ROBOTLASER1 0 -1 2 1 10 0.01 0 3 1 1 1 0 0 0 0 0 0 0 0 0 0 0 0 1.0 host 0.7\n");

  ASSERT_EQ(contents.messages.size(), 2U);
  EXPECT_EQ(std::get<LaserScan>(contents.messages[1]).ranges.size(), 3U);
}

TEST_F(CarmenRecordingTest, KeepsFileOrderWhereStampsStepBackOrRepeat) {
  write_file(file_, kHead + simple_flaser(2, 0, "10.0") + simple_flaser(2, 1, "9.5") + simple_flaser(2, 2, "9.5"));
  const auto recording = open_recording(file_);
  ASSERT_TRUE(recording);
  const Contents contents = read_all(**recording);

  EXPECT_FALSE((*recording)->info().stamp_ordered);
  EXPECT_EQ((*recording)->info().first_stamp, 9'500'000'000);
  EXPECT_EQ((*recording)->info().last_stamp, 10'000'000'000);
  EXPECT_TRUE(contents.rejected.empty());
  ASSERT_EQ(contents.messages.size(), 6U);
  EXPECT_DOUBLE_EQ(std::get<WheelOdometry>(contents.messages[4]).pose.x, 2.0);
}

TEST_F(CarmenRecordingTest, RejectsGarbledAndCutLinesAndGoesOn) {
  const std::string good = simple_flaser(2, 0, "1.0");
  const std::vector<std::pair<std::string, std::string>> cases{
      {"FLASER 2 1.0 nan 0 0 0 0 0 0 2.0 host 0.1\n", "'nan'"},
      {"FLASER 2 1.0 inf 0 0 0 0 0 0 2.0 host 0.1\n", "'inf'"},
      {"FLASER 2 1.0 -1.0 0 0 0 0 0 0 2.0 host 0.1\n", "'-1.0'"},
      {"FLASER 2 1.0 1.x 0 0 0 0 0 0 2.0 host 0.1\n", "'1.x'"},
      {"FLASER 2 1.0 1.0 0 0 0 nan 0 0 2.0 host 0.1\n", "'nan'"},
      {"FLASER 2 1.0 1.0 0 0 0 0 0 0 now host 0.1\n", "'now'"},
      {"FLASER 2 1.0 1.0 0 0 0 0 0 0 -5 host 0.1\n", "'-5'"},
      {"FLASER 2 1.0 1.0 0 0 0\n", "fewer"},
      {"FLASER 2 1.0 1.0 1.0 0 0 0 0 0 0 2.0 host 0.1\n", "more"},
      {"FLASER 999999999999 1.0\n", "a count from"},
      {"FLASER -2 1.0\n", "a count from"},
      {"FLASER\n", "fewer"},
      {simple_flaser(3, 0, "2.0"), "3 readings"},
      {"\x7f\x45LF garbage\n", "not a CARMEN message"},
  };
  for (const auto& [line, reason] : cases) {
    const Contents contents = read(good + line + good + good);
    EXPECT_EQ(contents.messages.size(), 6U) << line;
    ASSERT_EQ(contents.rejected.size(), 1U) << line;
    EXPECT_THAT(contents.rejected[0].reason, HasSubstr("sample.clf:2: "));
    EXPECT_THAT(contents.rejected[0].reason, HasSubstr(reason)) << line;
  }
}

TEST_F(CarmenRecordingTest, RejectsImpossibleRobotLaser1Geometry) {
  const std::string good = "ROBOTLASER1 0 -1 2 1 10 0.01 0 3 1 1 1 0 0 0 0 0 0 0 0 0 0 0 0 1.0 host 0.7\n";
  for (const char* const geometry : {"-1 2 0 10", "-1 2 9 10", "-1 2 1 0", "-99 2 1 10", "-1.1 2 1 10"}) {
    const Contents contents = read(good + std::string("ROBOTLASER1 0 ") + geometry +
                                   " 0.01 0 3 1 1 1 0 0 0 0 0 0 0 0 0 0 0 0 1.0 host 0.7\n");
    EXPECT_EQ(contents.messages.size(), 2U) << geometry;
    EXPECT_EQ(contents.rejected.size(), 1U) << geometry;
  }
}

TEST_F(CarmenRecordingTest, RefusesALogWithoutAScan) {
  const Contents contents = read(kHead + "ODOM 0 0 0 0 0 0 1.0 host 0\n");
  ASSERT_TRUE(contents.error);
  EXPECT_EQ(contents.error->kind, ErrorKind::kInvalidInput);
  EXPECT_THAT(contents.error->message, HasSubstr("no scan"));
}

std::string long_log() {
  std::string text = kHead;
  for (int i = 0; i < 400; ++i) text += simple_flaser(20, i * 0.1, std::to_string(i) + ".25");
  return text;
}

void write_gzip(const std::filesystem::path& path, const std::string& text) {
  const gzFile file = gzopen(path.c_str(), "wb");
  gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
  gzclose(file);
}

std::string bzip2(std::string text) {
  std::string packed(text.size() + 1000, '\0');
  auto size = static_cast<unsigned>(packed.size());
  BZ2_bzBuffToBuffCompress(packed.data(), &size, text.data(), static_cast<unsigned>(text.size()), 1, 0, 0);
  packed.resize(size);
  return packed;
}

TEST_F(CarmenRecordingTest, ReadsGzipAndBzip2WhateverTheFileIsCalled) {
  write_gzip(file_, long_log());
  EXPECT_EQ(open_and_read_all(file_).messages.size(), 800U);
  write_file(file_, bzip2(long_log()));
  EXPECT_EQ(open_and_read_all(file_).messages.size(), 800U);
}

TEST_F(CarmenRecordingTest, ReadsBzip2OfSeveralStreams) {
  const std::string text = long_log();
  const std::size_t half = text.find('\n', text.size() / 2) + 1;
  write_file(file_, bzip2(text.substr(0, half)) + bzip2(text.substr(half)));
  EXPECT_EQ(open_and_read_all(file_).messages.size(), 800U);
}

TEST_F(CarmenRecordingTest, KeepsWhatWasReadBeforeCompressedDataEnds) {
  write_gzip(file_, long_log());
  const std::string whole = read_file(file_);
  write_file(file_, whole.substr(0, whole.size() * 2 / 3));

  const Contents contents = open_and_read_all(file_);

  EXPECT_FALSE(contents.error);
  EXPECT_GT(contents.messages.size(), 100U);
  EXPECT_LT(contents.messages.size(), 800U);
  ASSERT_EQ(contents.rejected.size(), 1U);
  EXPECT_THAT(contents.rejected[0].reason, HasSubstr("ends early"));
}

TEST_F(CarmenRecordingTest, TurnsTheReferenceIntoPosesOfBaseLink) {
  write_file(file_, kHead + simple_flaser(2, 0, "1.5"));
  write_file(folder_.path() / "sample.reference.txt",
             "# index ipc logger x y theta\n0 1.5 0.1 1.0 2.0 1.5707963267949\n");

  const Result<Trajectory2> truth = read_ground_truth(file_);

  ASSERT_TRUE(truth) << truth.error().message;
  ASSERT_EQ(truth->size(), 1U);
  EXPECT_EQ((*truth)[0].stamp, 1'500'000'000);
  EXPECT_NEAR((*truth)[0].pose.x, 1.0, 1e-9);
  EXPECT_NEAR((*truth)[0].pose.y, 1.8, 1e-6);
}

TEST(CarmenLogs, OfRadishHaveTheirKnownNumbersOfScansAndPathLength) {
  const char* const root = std::getenv("SLAMFUSE_RECORDINGS");
  if (root == nullptr || *root == '\0') GTEST_SKIP() << "SLAMFUSE_RECORDINGS is not set: no real recordings to read";
  const std::array<std::pair<const char*, std::size_t>, 4> logs{
      {{"intel", 13631}, {"fr079", 4934}, {"aces", 7374}, {"mit-csail", 1988}}};
  for (const auto& [name, scans] : logs) {
    const auto file = std::filesystem::path(root) / "real" / "radish" / (std::string(name) + ".clf.bz2");
    const Contents contents = open_and_read_all(file);
    ASSERT_FALSE(contents.error) << contents.error->message;
    EXPECT_EQ(contents.count("laser0"), scans) << name;
    EXPECT_TRUE(contents.rejected.empty()) << name;
    if (std::string(name) != "intel") continue;
    Trajectory2 odometry;
    for (const SensorMessage& message : contents.messages) {
      if (const auto* wheels = std::get_if<WheelOdometry>(&message)) odometry.push_back({wheels->stamp, wheels->pose});
    }
    EXPECT_NEAR(path_length(odometry), 508.35, 0.01);
  }
}

}  // namespace
}  // namespace slamfuse::common
