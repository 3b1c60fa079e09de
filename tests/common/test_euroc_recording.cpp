// SPDX-License-Identifier: BSD-3-Clause
#include "common/euroc_recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/recording_samples.hpp"

namespace slamfuse::common {
namespace {

using namespace samples;
using ::testing::AllOf;
using ::testing::HasSubstr;

class EurocRecordingTest : public ::testing::Test {
 protected:
  void SetUp() override { write_euroc_sample(folder_.path()); }

  void replace(const std::string& file, const std::string& from, const std::string& to) {
    std::string text = read_file(folder_.path() / file);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write_file(folder_.path() / file, text.replace(at, from.size(), to));
  }

  std::string stamp(int milliseconds) const {
    return std::to_string(kSampleStart + Nanoseconds{milliseconds} * 1'000'000);
  }

  Contents read() const { return open_and_read_all(folder_.path()); }

  /// Reads with one row of a csv replaced; exactly one message must be missing and one rejected for `reason`.
  void expect_one_rejected(const std::string& sensor, const std::string& reason) {
    const Contents contents = read();
    ASSERT_FALSE(contents.error) << contents.error->message;
    ASSERT_EQ(contents.rejected.size(), 1U);
    EXPECT_EQ(contents.rejected[0].sensor, sensor);
    EXPECT_THAT(contents.rejected[0].reason, AllOf(HasSubstr(reason), HasSubstr("data.csv:")));
    EXPECT_EQ(contents.messages.size(), 20U);
  }

  void expect_error(const std::string& text) {
    const Result<std::unique_ptr<Recording>> recording = open_recording(folder_.path());
    ASSERT_FALSE(recording);
    EXPECT_EQ(recording.error().kind, ErrorKind::kInvalidInput);
    EXPECT_THAT(recording.error().message, HasSubstr(text));
  }

  TemporaryFolder folder_;
};

TEST_F(EurocRecordingTest, TellsSensorsTimesAndCalibration) {
  const auto recording = open_recording(folder_.path());

  ASSERT_TRUE(recording) << recording.error().message;
  const RecordingInfo& info = (*recording)->info();
  EXPECT_EQ(info.format, "euroc");
  EXPECT_TRUE(info.stamp_ordered);
  EXPECT_EQ(info.first_stamp, kSampleStart);
  EXPECT_EQ(info.last_stamp, kSampleStart + kNanosecondsPerSecond);
  ASSERT_EQ(info.sensors.size(), 3U);
  EXPECT_EQ(info.sensors.at("odom0").messages, 11U);
  EXPECT_EQ(info.sensors.at("cam0").kind, SensorKind::kCamera);
  EXPECT_EQ(info.sensors.at("laser0").last_stamp, kSampleStart + 800'000'000);
  const LaserCalibration& laser = info.calibration.lasers.at("laser0");
  EXPECT_EQ(laser.beams, 4);
  EXPECT_DOUBLE_EQ(laser.sweep_duration, 0.02);
  EXPECT_DOUBLE_EQ(laser.T_base_laser.translation.x(), 0.12);
  const CameraCalibration& camera = info.calibration.cameras.at("cam0");
  EXPECT_EQ(camera.width, 16);
  EXPECT_DOUBLE_EQ(camera.fy, 21.0);
  EXPECT_DOUBLE_EQ(camera.p2, 0.002);
  EXPECT_TRUE((camera.T_base_camera * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(1.1, 0.2, 0.3), 1e-12));
}

TEST_F(EurocRecordingTest, MergesByStampOdometryBeforeLaserBeforeCamera) {
  const Contents contents = read();

  ASSERT_FALSE(contents.error);
  EXPECT_TRUE(contents.rejected.empty());
  ASSERT_EQ(contents.messages.size(), 21U);
  EXPECT_EQ(sensor_of(contents.messages[0]), "odom0");
  EXPECT_EQ(sensor_of(contents.messages[1]), "laser0");
  EXPECT_EQ(sensor_of(contents.messages[2]), "cam0");
  for (std::size_t i = 1; i < contents.messages.size(); ++i) {
    EXPECT_LE(stamp_of(contents.messages[i - 1]), stamp_of(contents.messages[i]));
  }
}

TEST_F(EurocRecordingTest, ReadsValuesOfEverySensor) {
  const Contents contents = read();

  const auto& odometry = std::get<WheelOdometry>(contents.messages[3]);
  EXPECT_EQ(odometry.stamp, kSampleStart + 100'000'000);
  EXPECT_DOUBLE_EQ(odometry.pose.x, 0.05);
  EXPECT_DOUBLE_EQ(odometry.forward_speed, 0.5);
  EXPECT_DOUBLE_EQ(odometry.turn_rate, 0.1);
  const auto& scan = std::get<LaserScan>(contents.messages[1]);
  ASSERT_EQ(scan.ranges.size(), 4U);
  EXPECT_FLOAT_EQ(scan.ranges[0], 1.5F);
  EXPECT_TRUE(std::isnan(scan.ranges[1])) << "0 is no return";
  EXPECT_TRUE(std::isinf(scan.ranges[3])) << "7 m is beyond the range of 5 m";
  const auto& image = std::get<Image>(contents.messages[2]);
  EXPECT_EQ(image.width, 16);
  ASSERT_EQ(image.pixels->size(), 16U * 12U);
  EXPECT_NEAR((*image.pixels)[0], 0, 12);
  EXPECT_NEAR((*image.pixels)[16 * 11 + 5], (5 * 13 + 11 * 7) % 256, 12);
}

TEST_F(EurocRecordingTest, ReadsAFolderInsideMav0AndWindowsLineEnds) {
  TemporaryFolder outer;
  write_euroc_sample(outer.path() / "mav0");
  std::string text = read_file(outer.path() / "mav0" / "odom0" / "data.csv");
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.insert(at, "\r");
  write_file(outer.path() / "mav0" / "odom0" / "data.csv", text);

  const Contents contents = open_and_read_all(outer.path());

  EXPECT_FALSE(contents.error);
  EXPECT_EQ(contents.messages.size(), 21U);
}

TEST_F(EurocRecordingTest, ReadsCsvWithoutHeader) {
  replace("odom0/data.csv", "#timestamp [ns],x [m],y [m],theta [rad],v [m s^-1],omega [rad s^-1]\n", "");

  EXPECT_EQ(read().count("odom0"), 11U);
}

TEST_F(EurocRecordingTest, ReadsImu) {
  write_file(
      folder_.path() / "imu0" / "data.csv",
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m "
      "s^-2],a_RS_S_z [m s^-2]\n" +
          stamp(0) + ",0.1,0.2,0.3,1,2,9.81\n");

  const Contents contents = read();

  ASSERT_EQ(contents.count("imu0"), 1U);
  const auto& imu = std::get<Imu>(contents.messages[1]);
  EXPECT_TRUE(imu.angular_velocity.isApprox(Eigen::Vector3d(0.1, 0.2, 0.3)));
  EXPECT_TRUE(imu.linear_acceleration.isApprox(Eigen::Vector3d(1, 2, 9.81)));
}

TEST_F(EurocRecordingTest, RejectsAScanWithNan) {
  replace("laser0/data.csv", stamp(400) + ",1.5,0", stamp(400) + ",1.5,nan");
  expect_one_rejected("laser0", "'nan'");
}

TEST_F(EurocRecordingTest, RejectsAScanWithInfinity) {
  replace("laser0/data.csv", stamp(400) + ",1.5,0", stamp(400) + ",1.5,inf");
  expect_one_rejected("laser0", "'inf'");
}

TEST_F(EurocRecordingTest, RejectsAScanWithANegativeRange) {
  replace("laser0/data.csv", stamp(400) + ",1.5,0", stamp(400) + ",1.5,-0.5");
  expect_one_rejected("laser0", "range -0.5");
}

TEST_F(EurocRecordingTest, RejectsAScanWithTooFewRanges) {
  replace("laser0/data.csv", stamp(400) + ",1.5,0,2.25,7.0", stamp(400) + ",1.5,0,2.25");
  expect_one_rejected("laser0", "3 values behind the stamp (allowed: 4 ranges)");
}

TEST_F(EurocRecordingTest, RejectsAScanWithTooManyRanges) {
  replace("laser0/data.csv", stamp(400) + ",1.5,0,2.25,7.0", stamp(400) + ",1.5,0,2.25,1,1");
  expect_one_rejected("laser0", "5 values");
}

TEST_F(EurocRecordingTest, RejectsAScanWithGarbledNumber) {
  replace("laser0/data.csv", stamp(400) + ",1.5,0,2.25", stamp(400) + ",1.5,0,2.\x01#5");
  expect_one_rejected("laser0", "'2.?#5'");
}

TEST_F(EurocRecordingTest, RejectsOdometryThatIsNotFinite) {
  replace("odom0/data.csv", stamp(400) + ",0.200000,0.0", stamp(400) + ",0.200000,nan");
  expect_one_rejected("odom0", "'nan'");
}

TEST_F(EurocRecordingTest, RejectsAStampThatRepeats) {
  replace("odom0/data.csv", stamp(500), stamp(400));
  expect_one_rejected("odom0", "repeats");
}

TEST_F(EurocRecordingTest, RejectsAStampThatStepsBack) {
  replace("odom0/data.csv", stamp(500), stamp(150));
  expect_one_rejected("odom0", "steps back");
}

TEST_F(EurocRecordingTest, RejectsOnlyTheRowWhoseStampJumpsAhead) {
  replace("odom0/data.csv", stamp(500), stamp(50'000));
  expect_one_rejected("odom0", "runs ahead");
}

TEST_F(EurocRecordingTest, RejectsAStampThatIsNoNumber) {
  replace("odom0/data.csv", stamp(500), "17e8");
  expect_one_rejected("odom0", "stamp '17e8'");
}

TEST_F(EurocRecordingTest, RejectsALineWithoutEndInBoundedMemory) {
  replace("odom0/data.csv", stamp(500) + ",0.25", stamp(500) + "," + std::string(5'000'000, '1'));
  expect_one_rejected("odom0", "line longer than");
}

TEST_F(EurocRecordingTest, RejectsAMissingImage) {
  std::filesystem::remove(folder_.path() / "cam0" / "data" / (stamp(400) + ".jpg"));
  expect_one_rejected("cam0", "no such file");
}

TEST_F(EurocRecordingTest, RejectsACutImage) {
  const std::filesystem::path file = folder_.path() / "cam0" / "data" / (stamp(400) + ".jpg");
  const std::string whole = read_file(file);
  write_file(file, whole.substr(0, whole.size() * 3 / 4));
  expect_one_rejected("cam0", "cut or garbled JPEG");
}

TEST_F(EurocRecordingTest, RejectsAnEmptyImageFile) {
  write_file(folder_.path() / "cam0" / "data" / (stamp(400) + ".jpg"), "");
  expect_one_rejected("cam0", "empty image file");
}

TEST_F(EurocRecordingTest, RejectsAnImageOfTheWrongSize) {
  write_file(folder_.path() / "cam0" / "data" / (stamp(400) + ".jpg"), encoded_image(".jpg", 1, 32, 12));
  expect_one_rejected("cam0", "32x12 pixels (expected: 16x12)");
}

TEST_F(EurocRecordingTest, RejectsAFileNameThatLeavesTheFolder) {
  write_file(folder_.path() / "cam0" / "secret.jpg", encoded_image(".jpg", 1));
  replace("cam0/data.csv", stamp(400) + ".jpg", "../secret.jpg");
  expect_one_rejected("cam0", "inside the sensor's data folder");
}

TEST_F(EurocRecordingTest, RejectsAnAbsoluteFileName) {
  replace("cam0/data.csv", stamp(400) + ".jpg", (folder_.path() / "cam0/data" / (stamp(0) + ".jpg")).string());
  expect_one_rejected("cam0", "inside the sensor's data folder");
}

TEST_F(EurocRecordingTest, RejectsAFolderInPlaceOfAnImage) {
  std::filesystem::remove(folder_.path() / "cam0" / "data" / (stamp(400) + ".jpg"));
  std::filesystem::create_directory(folder_.path() / "cam0" / "data" / (stamp(400) + ".jpg"));
  expect_one_rejected("cam0", "no such file");
}

TEST_F(EurocRecordingTest, StampsARejectionBeforeAnyGoodMessageWithTheStart) {
  replace("odom0/data.csv", stamp(0) + ",", "x,");
  const Contents contents = read();
  ASSERT_EQ(contents.rejected.size(), 1U);
  EXPECT_EQ(contents.rejected[0].stamp, kSampleStart);
}

TEST_F(EurocRecordingTest, RefusesAMissingFolder) {
  const auto recording = open_recording(folder_.path() / "nowhere");
  ASSERT_FALSE(recording);
  EXPECT_EQ(recording.error().kind, ErrorKind::kInvalidInput);
  EXPECT_THAT(recording.error().message, AllOf(HasSubstr("nowhere"), HasSubstr("no such")));
}

TEST_F(EurocRecordingTest, RefusesAnEmptyFolder) {
  TemporaryFolder empty;
  const auto recording = open_recording(empty.path());
  ASSERT_FALSE(recording);
  EXPECT_THAT(recording.error().message, HasSubstr("not a known recording"));
}

TEST_F(EurocRecordingTest, RefusesARecordingWithoutAnyMessage) {
  write_file(folder_.path() / "odom0/data.csv", "#timestamp [ns],x [m],y [m],theta [rad]\n");
  write_file(folder_.path() / "laser0/data.csv", "#timestamp [ns],ranges [m]\n");
  write_file(folder_.path() / "cam0/data.csv", "#timestamp [ns],filename\n");
  expect_error("empty recording");
}

TEST_F(EurocRecordingTest, PlaysOnWhenOnlyOneSensorIsSilent) {
  write_file(folder_.path() / "cam0/data.csv", "#timestamp [ns],filename\n");
  const Contents contents = read();
  EXPECT_FALSE(contents.error);
  EXPECT_EQ(contents.messages.size(), 16U);
}

TEST_F(EurocRecordingTest, RefusesSensorsWithoutCommonTime) {
  write_file(folder_.path() / "odom0/data.csv",
             "#timestamp [ns],x [m],y [m],theta [rad]\n" + stamp(5000) + ",0,0,0\n" + stamp(5100) + ",0,0,0\n");
  expect_error("no time in common: odom0 starts at");
}

TEST_F(EurocRecordingTest, RefusesUnexpectedColumns) {
  replace("odom0/data.csv", ",x [m],y [m]", ",y [m],x [m]");
  expect_error("column 2 is 'y [m]'");
}

TEST_F(EurocRecordingTest, RefusesTooFewColumnsWithoutHeader) {
  write_file(folder_.path() / "odom0/data.csv", stamp(0) + ",0.1\n");
  expect_error("2 columns");
}

TEST_F(EurocRecordingTest, RefusesACsvWithoutAUsableStamp) {
  write_file(folder_.path() / "odom0/data.csv", "#timestamp [ns],x [m],y [m],theta [rad]\n0.5;1;2;3\n");
  expect_error("no row has a usable stamp");
}

TEST_F(EurocRecordingTest, RefusesAnEmptyCsv) {
  write_file(folder_.path() / "laser0/data.csv", "");
  expect_error("laser0/data.csv: empty");
}

TEST_F(EurocRecordingTest, RefusesAMissingCsv) {
  std::filesystem::remove(folder_.path() / "laser0/data.csv");
  expect_error("laser0/data.csv: no such file");
}

TEST_F(EurocRecordingTest, RefusesAMissingSensorYaml) {
  std::filesystem::remove(folder_.path() / "cam0/sensor.yaml");
  expect_error("cam0/sensor.yaml: no such file");
}

TEST_F(EurocRecordingTest, RefusesTheFolderOfOneSensorWithAHint) {
  const auto recording = open_recording(folder_.path() / "cam0");
  ASSERT_FALSE(recording);
  EXPECT_THAT(recording.error().message, HasSubstr("open the folder that holds it"));
}

TEST_F(EurocRecordingTest, ReadsGroundTruthWithTheScalarFirst) {
  write_file(
      folder_.path() / "state_groundtruth_estimate0/data.csv",
      "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w,q_x,q_y,q_z\n" + stamp(0) + ",1,2,0,0.70710678,0,0,0.70710678\n");

  const Result<Trajectory2> truth = read_ground_truth(folder_.path());

  ASSERT_TRUE(truth) << truth.error().message;
  ASSERT_EQ(truth->size(), 1U);
  EXPECT_EQ((*truth)[0].stamp, kSampleStart);
  EXPECT_DOUBLE_EQ((*truth)[0].pose.y, 2.0);
  EXPECT_NEAR((*truth)[0].pose.theta, M_PI / 2, 1e-9);
}

TEST_F(EurocRecordingTest, HasNoGroundTruthWhereThereIsNone) {
  const Result<Trajectory2> truth = read_ground_truth(folder_.path());
  ASSERT_TRUE(truth);
  EXPECT_TRUE(truth->empty());
}

TEST_F(EurocRecordingTest, RefusesGarbledGroundTruth) {
  write_file(folder_.path() / "state_groundtruth_estimate0/data.csv",
             "#timestamp [ns],p_x [m]\n" + stamp(0) + ",1,2,0,1,0,0,x\n");
  const Result<Trajectory2> truth = read_ground_truth(folder_.path());
  ASSERT_FALSE(truth);
  EXPECT_THAT(truth.error().message, HasSubstr("data.csv:2"));
}

}  // namespace
}  // namespace slamfuse::common
