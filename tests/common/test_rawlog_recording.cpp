// SPDX-License-Identifier: BSD-3-Clause
#include "common/rawlog_recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "common/recording_samples.hpp"

namespace slamfuse::common {
namespace {

using namespace samples;
using ::testing::HasSubstr;

/// Collects MRPT objects as the bytes of a rawlog.
class RawlogWriter {
 public:
  template <class Object>
  RawlogWriter& add(const Object& object) {
    auto archive = mrpt::serialization::archiveFrom(stream_);
    archive << object;
    return *this;
  }
  std::string bytes() {
    return {static_cast<const char*>(stream_.getRawBufferData()),
            static_cast<std::size_t>(stream_.getTotalBytesCount())};
  }

 private:
  mrpt::io::CMemoryStream stream_;
};

mrpt::Clock::time_point at(double seconds) { return mrpt::Clock::fromDouble(1e9 + seconds); }

mrpt::obs::CObservation2DRangeScan scan_at(double seconds, const std::string& label = "") {
  mrpt::obs::CObservation2DRangeScan scan;
  scan.timestamp = at(seconds);
  scan.sensorLabel = label;
  scan.aperture = static_cast<float>(std::numbers::pi);
  scan.maxRange = 10.0F;
  scan.sensorPose = mrpt::poses::CPose3D(0.3, 0.0, 0.2, 0.0, 0.0, 0.0);
  scan.resizeScan(5);
  for (std::size_t i = 0; i < 5; ++i) {
    scan.setScanRange(i, 1.0F + static_cast<float>(i));
    scan.setScanRangeValidity(i, true);
  }
  return scan;
}

mrpt::obs::CActionCollection action(double x, double turn) {
  mrpt::obs::CActionRobotMovement2D movement;
  movement.computeFromOdometry(mrpt::poses::CPose2D(x, 0, turn), {});
  mrpt::obs::CActionCollection actions;
  actions.insert(movement);
  return actions;
}

mrpt::obs::CSensoryFrame frame_of(const mrpt::obs::CObservation2DRangeScan& scan) {
  mrpt::obs::CSensoryFrame frame;
  frame.insert(std::make_shared<mrpt::obs::CObservation2DRangeScan>(scan));
  return frame;
}

class RawlogRecordingTest : public ::testing::Test {
 protected:
  Contents read(const std::string& bytes) {
    write_file(file_, bytes);
    return open_and_read_all(file_);
  }
  static std::string action_observation_log() {
    RawlogWriter log;
    log.add(frame_of(scan_at(0)));
    for (int i = 1; i <= 3; ++i) log.add(action(1.0, std::numbers::pi / 2)).add(frame_of(scan_at(i)));
    return log.bytes();
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "sample.rawlog";
};

TEST_F(RawlogRecordingTest, IntegratesTheOdometryOfActionsUpToEachFrame) {
  const Contents contents = read(action_observation_log());

  ASSERT_FALSE(contents.error) << contents.error->message;
  ASSERT_EQ(contents.messages.size(), 8U);
  const auto& start = std::get<WheelOdometry>(contents.messages[0]);
  EXPECT_EQ(start.stamp, stamp_of(contents.messages[1]));
  EXPECT_DOUBLE_EQ(start.pose.x, 0.0);
  const auto& second = std::get<WheelOdometry>(contents.messages[4]);
  EXPECT_NEAR(second.pose.x, 1.0, 1e-9);
  EXPECT_NEAR(second.pose.y, 1.0, 1e-9);
  EXPECT_NEAR(second.pose.theta, std::numbers::pi, 1e-9);
  EXPECT_EQ(second.stamp, 1'000'000'002'000'000'000);
}

TEST_F(RawlogRecordingTest, ReadsObservationOnlyLogs) {
  mrpt::obs::CObservationOdometry odometry;
  odometry.timestamp = at(0.5);
  odometry.odometry = mrpt::poses::CPose2D(1, 2, 0.5);
  odometry.hasVelocities = true;
  odometry.velocityLocal = {0.7, 0, 0.2};
  mrpt::obs::CObservationComment comment;
  comment.text = "left alone";

  const Contents contents = read(RawlogWriter().add(comment).add(scan_at(0.4)).add(odometry).add(scan_at(0.6)).bytes());

  ASSERT_FALSE(contents.error) << contents.error->message;
  ASSERT_EQ(contents.messages.size(), 3U);
  const auto& wheels = std::get<WheelOdometry>(contents.messages[1]);
  EXPECT_EQ(wheels.stamp, 1'000'000'000'500'000'000);
  EXPECT_DOUBLE_EQ(wheels.pose.y, 2.0);
  EXPECT_DOUBLE_EQ(wheels.forward_speed, 0.7);
  EXPECT_DOUBLE_EQ(wheels.turn_rate, 0.2);
}

TEST_F(RawlogRecordingTest, GivesNoOdometryWithoutActions) {
  const Contents contents = read(RawlogWriter().add(frame_of(scan_at(0))).add(frame_of(scan_at(1))).bytes());
  EXPECT_EQ(contents.count("odom0"), 0U);
  EXPECT_EQ(contents.count("laser0"), 2U);
}

TEST_F(RawlogRecordingTest, TakesTheGeometryFromTheFirstScanAlsoUpsideDown) {
  mrpt::obs::CObservation2DRangeScan scan = scan_at(0);
  scan.sensorPose = mrpt::poses::CPose3D(0.3, 0.1, 0.2, 0.0, 0.0, std::numbers::pi);
  write_file(file_, RawlogWriter().add(scan).bytes());

  const auto recording = open_recording(file_);

  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ((*recording)->info().format, "rawlog");
  const LaserCalibration& laser = (*recording)->info().calibration.lasers.at("laser0");
  EXPECT_EQ(laser.beams, 5);
  EXPECT_NEAR(laser.angle_min, -std::numbers::pi / 2, 1e-6);
  EXPECT_NEAR(laser.angle_increment, std::numbers::pi / 4, 1e-6);
  EXPECT_DOUBLE_EQ(laser.range_max, 10.0);
  EXPECT_TRUE((laser.T_base_laser * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(0.3, -0.9, 0.2), 1e-9));
}

TEST_F(RawlogRecordingTest, TurnsScansFromLeftToRightRound) {
  mrpt::obs::CObservation2DRangeScan scan = scan_at(0);
  scan.rightToLeft = false;

  const Contents contents = read(RawlogWriter().add(scan).bytes());

  EXPECT_FLOAT_EQ(std::get<LaserScan>(contents.messages.at(0)).ranges.front(), 5.0F);
}

// MRPT copies the byte into a bool as it is: found by fuzzing.
TEST_F(RawlogRecordingTest, TakesATruthValueThatIsNeitherForTrue) {
  mrpt::obs::CObservation2DRangeScan scan = scan_at(0);
  std::string bytes = RawlogWriter().add(scan).bytes();
  scan.rightToLeft = false;
  const std::string turned = RawlogWriter().add(scan).bytes();
  const auto flag = std::ranges::mismatch(bytes, turned).in1;
  ASSERT_NE(flag, bytes.end());
  *flag = 33;

  const Contents contents = read(bytes);

  EXPECT_FLOAT_EQ(std::get<LaserScan>(contents.messages.at(0)).ranges.front(), 1.0F);
}

TEST_F(RawlogRecordingTest, KeepsNoMeasurementAndBeyondRangeApart) {
  mrpt::obs::CObservation2DRangeScan scan = scan_at(0);
  scan.setScanRange(0, 0.0F);
  scan.setScanRangeValidity(0, false);
  scan.setScanRange(1, 12.0F);
  scan.setScanRangeValidity(1, false);

  const Contents contents = read(RawlogWriter().add(scan).bytes());

  const auto& ranges = std::get<LaserScan>(contents.messages.at(0)).ranges;
  EXPECT_TRUE(std::isnan(ranges[0]));
  EXPECT_TRUE(std::isinf(ranges[1]));
  EXPECT_FLOAT_EQ(ranges[2], 3.0F);
}

TEST_F(RawlogRecordingTest, TellsLasersApartByTheirLabels) {
  const Contents contents = read(RawlogWriter()
                                     .add(scan_at(0, "FRONT"))
                                     .add(scan_at(0, "REAR"))
                                     .add(scan_at(1, "FRONT"))
                                     .add(scan_at(1, "REAR"))
                                     .bytes());
  EXPECT_EQ(contents.count("laser0"), 2U);
  EXPECT_EQ(contents.count("laser1"), 2U);
}

TEST_F(RawlogRecordingTest, RejectsBadScansAndGoesOn) {
  mrpt::obs::CObservation2DRangeScan not_a_number = scan_at(1);
  not_a_number.setScanRange(2, std::numeric_limits<float>::quiet_NaN());
  mrpt::obs::CObservation2DRangeScan negative = scan_at(2);
  negative.setScanRange(2, -1.0F);
  mrpt::obs::CObservation2DRangeScan short_scan = scan_at(3);
  short_scan.resizeScan(4);
  mrpt::obs::CObservation2DRangeScan moved = scan_at(4);
  moved.sensorPose = mrpt::poses::CPose3D(0.9, 0, 0.2, 0, 0, 0);
  mrpt::obs::CObservation2DRangeScan no_stamp = scan_at(5);
  no_stamp.timestamp = mrpt::Clock::time_point();

  const Contents contents = read(RawlogWriter()
                                     .add(scan_at(0))
                                     .add(not_a_number)
                                     .add(negative)
                                     .add(short_scan)
                                     .add(moved)
                                     .add(no_stamp)
                                     .add(scan_at(4))
                                     .add(scan_at(-1))
                                     .add(scan_at(9))
                                     .bytes());

  EXPECT_EQ(contents.messages.size(), 2U);
  ASSERT_EQ(contents.rejected.size(), 7U);
  EXPECT_THAT(contents.rejected[0].reason, HasSubstr("entry 2: valid range nan"));
  EXPECT_THAT(contents.rejected[1].reason, HasSubstr("-1"));
  EXPECT_THAT(contents.rejected[2].reason, HasSubstr("another number of readings"));
  EXPECT_THAT(contents.rejected[3].reason, HasSubstr("mounting"));
  EXPECT_THAT(contents.rejected[4].reason, HasSubstr("no usable stamp"));
  EXPECT_THAT(contents.rejected[5].reason, HasSubstr("repeats"));
  EXPECT_THAT(contents.rejected[6].reason, HasSubstr("steps back"));
}

TEST_F(RawlogRecordingTest, KeepsWhatWasReadBeforeACut) {
  const std::string whole = action_observation_log();

  const Contents contents = read(whole.substr(0, whole.size() - 20));

  EXPECT_FALSE(contents.error);
  EXPECT_EQ(contents.messages.size(), 6U);
  ASSERT_EQ(contents.rejected.size(), 1U);
  EXPECT_THAT(contents.rejected[0].reason, HasSubstr("the file ends in the middle of an entry"));
}

TEST_F(RawlogRecordingTest, ReadsAnyTruncationWithoutCrash) {
  const std::string whole = action_observation_log();
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    const Contents contents = read(whole.substr(0, size));
    EXPECT_LT(contents.messages.size(), 8U) << size;
    EXPECT_TRUE(contents.error || !contents.rejected.empty() || !contents.messages.empty()) << size;
  }
}

// MRPT makes room for all of them first: found by fuzzing.
TEST_F(RawlogRecordingTest, RefusesAFrameOfBillions) {
  std::string bytes = action_observation_log();
  const std::string name = "mrpt::obs::CSensoryFrame";
  const std::size_t count = bytes.rfind(name) + name.size() + 1;  // behind the version
  bytes.replace(count, 4, "\xff\xff\xff\x7f");
  const Contents contents = read(bytes);
  ASSERT_FALSE(contents.error);
  ASSERT_EQ(contents.rejected.size(), 1U);
  EXPECT_THAT(contents.rejected[0].reason, HasSubstr("a frame says it holds 2147483647 observations"));
}

// MRPT uses a null pointer when another object follows than the number says: found by fuzzing.
TEST_F(RawlogRecordingTest, RefusesAMovementWithoutAPose) {
  std::string bytes = action_observation_log();
  const std::string name = "mrpt::obs::CActionRobotMovement2D";
  const std::size_t method = bytes.rfind(name) + name.size() + 1;  // behind the version
  bytes.replace(method, 4, std::string("\1\0\0\0", 4));            // no odometry, so a CPosePDF is to follow
  const Contents contents = read(bytes);
  ASSERT_FALSE(contents.error);
  ASSERT_EQ(contents.rejected.size(), 1U);
  EXPECT_THAT(contents.rejected[0].reason, HasSubstr("a movement holds no pose"));
}

// MRPT takes all it finds in a collection for actions, without a look: found by fuzzing.
TEST_F(RawlogRecordingTest, RefusesACollectionOfSomethingElseThanActions) {
  mrpt::obs::CActionRobotMovement2D movement;
  movement.computeFromOdometry(mrpt::poses::CPose2D(1.0, 0, 0.5), {});
  mrpt::obs::CActionCollection actions;
  actions.insert(movement);
  actions.insert(movement);
  const std::string bytes = RawlogWriter().add(frame_of(scan_at(0))).add(actions).add(frame_of(scan_at(1))).bytes();
  EXPECT_TRUE(read(bytes).rejected.empty());
  const std::string name = "mrpt::obs::CActionRobotMovement2D";
  for (const std::size_t place : {bytes.find(name), bytes.rfind(name)}) {
    std::string damaged = bytes;
    damaged.replace(place, name.size(), "mrpt::obs::CActio::poses::CPose2D");
    const Contents contents = read(damaged);
    ASSERT_FALSE(contents.error);
    ASSERT_EQ(contents.rejected.size(), 1U);
    EXPECT_THAT(contents.rejected[0].reason, HasSubstr("a collection of actions holds something else"));
  }
}

TEST_F(RawlogRecordingTest, RefusesACollectionOfBillionsOfActions) {
  std::string bytes = action_observation_log();
  const std::string name = "mrpt::obs::CActionCollection";
  bytes.replace(bytes.rfind(name) + name.size() + 1, 4, "\xff\xff\xff\x7f");
  const Contents contents = read(bytes);
  ASSERT_EQ(contents.rejected.size(), 1U);
  EXPECT_THAT(contents.rejected[0].reason, HasSubstr("a collection says it holds 2147483647 actions"));
}

TEST_F(RawlogRecordingTest, ReadsMovementsThatAreNoOdometry) {
  mrpt::obs::CActionRobotMovement2D movement;
  movement.computeFromOdometry(mrpt::poses::CPose2D(1.0, 0, 0.5), {});
  movement.estimationMethod = mrpt::obs::CActionRobotMovement2D::emScan2DMatching;
  mrpt::obs::CActionCollection actions;
  actions.insert(movement);
  const Contents contents =
      read(RawlogWriter().add(frame_of(scan_at(0))).add(actions).add(frame_of(scan_at(1))).bytes());
  ASSERT_FALSE(contents.error) << contents.error->message;
  EXPECT_TRUE(contents.rejected.empty());
}

// MRPT draws all of them.
TEST_F(RawlogRecordingTest, RefusesAMovementOfBillionsOfParticles) {
  mrpt::obs::CActionRobotMovement2D movement;
  mrpt::obs::CActionRobotMovement2D::TMotionModelOptions model;
  model.modelSelection = mrpt::obs::CActionRobotMovement2D::mmThrun;
  model.thrunModel.nParticlesCount = 54321;  // a number that is found again
  movement.computeFromOdometry(mrpt::poses::CPose2D(1.0, 0, 0.5), model);
  mrpt::obs::CActionCollection actions;
  actions.insert(movement);
  std::string bytes = RawlogWriter().add(frame_of(scan_at(0))).add(actions).add(frame_of(scan_at(1))).bytes();
  EXPECT_TRUE(read(bytes).rejected.empty());
  const std::uint32_t particles = 54321;
  const std::size_t count = bytes.find(std::string(reinterpret_cast<const char*>(&particles), sizeof(particles)));
  ASSERT_NE(count, std::string::npos);
  bytes.replace(count, 4, "\xff\xff\xff\x7f");
  const Contents contents = read(bytes);
  ASSERT_EQ(contents.rejected.size(), 1U);
  EXPECT_THAT(contents.rejected[0].reason, HasSubstr("a movement says it has 2147483647 particles"));
}

// MRPT makes room for a string or an array before it reads on: found by fuzzing.
TEST_F(RawlogRecordingTest, RefusesLengthsThatTheFileDoesNotHold) {
  const std::string label = "a name found again";
  const std::string good = RawlogWriter().add(scan_at(0, label)).add(scan_at(1, label)).bytes();
  EXPECT_TRUE(read(good).rejected.empty());
  const std::size_t of_label = good.rfind(label) - 4;
  const std::string readings("\5\0\0\0\0\0\x80\x3f", 8);  // five, the first of 1 m
  const std::size_t of_readings = good.rfind(readings);
  ASSERT_NE(of_readings, std::string::npos);
  for (const std::size_t place : {of_label, of_readings}) {
    for (const std::string length : {"\xff\xff\xff\xff", "\xff\xff\xff\x7f", "\x01\x01\x01\x01"}) {
      std::string bytes = good;
      bytes.replace(place, 4, length);
      const Contents contents = read(bytes);
      ASSERT_FALSE(contents.error) << contents.error->message;
      ASSERT_EQ(contents.rejected.size(), 1U);
      EXPECT_THAT(contents.rejected[0].reason, HasSubstr("sample.rawlog"));
      EXPECT_THAT(contents.rejected[0].reason, HasSubstr("an object says it holds"));
      EXPECT_THAT(contents.rejected[0].reason, HasSubstr("bytes left in the file"));
    }
  }
}

TEST_F(RawlogRecordingTest, ReadsGzip) {
  const std::string bytes = action_observation_log();
  const gzFile file = gzopen(file_.c_str(), "wb");
  gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size()));
  gzclose(file);

  EXPECT_EQ(open_and_read_all(file_).messages.size(), 8U);
}

TEST_F(RawlogRecordingTest, RefusesALogWithoutScanOrOdometry) {
  mrpt::obs::CObservationComment comment;
  const Contents contents = read(RawlogWriter().add(comment).bytes());
  ASSERT_TRUE(contents.error);
  EXPECT_EQ(contents.error->kind, ErrorKind::kInvalidInput);
}

TEST_F(RawlogRecordingTest, ReadsTheLogThatMrptShips) {
  const std::filesystem::path file = "/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not installed (package mrpt-common)";

  const Contents contents = open_and_read_all(file);

  ASSERT_FALSE(contents.error);
  EXPECT_EQ(contents.count("laser0"), 225U);
  EXPECT_EQ(contents.count("odom0"), 225U);
  EXPECT_TRUE(contents.rejected.empty());
}

}  // namespace
}  // namespace slamfuse::common
