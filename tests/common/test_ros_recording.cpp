// SPDX-License-Identifier: BSD-3-Clause
#include "common/recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "common/recording_samples.hpp"
#include "common/ros_bag_samples.hpp"

namespace slamfuse::common {
namespace {

using namespace samples;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr Nanoseconds kTick = kNanosecondsPerSecond / 10;
Nanoseconds at(int tick) { return kSampleStart + tick * kTick; }

/// One second of a robot: static mounting of the laser, odometry and scans, a motion capture.
std::vector<BagSample> robot(Wire wire) {
  std::vector<BagSample> samples;
  samples.push_back(
      {"/tf_static", "tf2_msgs/TFMessage", at(0),
       transforms_message(wire, at(0),
                          {{"base_link", "deck", planar(0.1, 0.0, 0.0)}, {"deck", "laser", planar(0.2, 0.05, 0.5)}})});
  for (int tick = 0; tick < 10; ++tick) {
    SampleScan scan;
    scan.stamp = at(tick);
    const double x = 0.1 * tick;
    samples.push_back({"/odom", "nav_msgs/Odometry", at(tick) + 1,
                       odometry_message(wire, at(tick), "base_link", planar(x, 0.0, 0.0), 1.0)});
    samples.push_back({"/scan", "sensor_msgs/LaserScan", at(tick) + 2, scan_message(wire, scan)});
    samples.push_back({"/vrpn_client_node/robot/pose", "geometry_msgs/PoseStamped", at(tick) + 3,
                       pose_message(wire, at(tick), planar(x, 5.0, 0.0))});
    samples.push_back({"/battery", "sensor_msgs/BatteryState", at(tick) + 4, "whatever"});
  }
  return samples;
}

/// All kinds of bags, and all compressions.
enum class Storage { kRos1, kSqlite, kMcap };
struct BagKind {
  const char* name;
  Storage storage;
  const char* compression;
};

class EveryBag : public testing::TestWithParam<BagKind> {
 protected:
  bool ros1() const { return GetParam().storage == Storage::kRos1; }
  Wire wire() const { return ros1() ? Wire::kRos1 : Wire::kCdr; }
  /// The file that holds the messages.
  std::filesystem::path write_messages(const std::vector<BagSample>& samples) const {
    if (GetParam().storage == Storage::kSqlite) return write_ros2_bag(folder_.path() / "bag", samples);
    if (GetParam().storage == Storage::kMcap) {
      return write_mcap_bag(folder_.path() / "bag", samples, GetParam().compression);
    }
    write_file(folder_.path() / "file.bag", ros1_bag(samples, GetParam().compression));
    return folder_.path() / "file.bag";
  }
  /// The bag as a user names it.
  std::filesystem::path write(const std::vector<BagSample>& samples) const {
    const auto file = write_messages(samples);
    return ros1() ? file : file.parent_path();
  }
  Contents read(const std::vector<BagSample>& samples) const { return open_and_read_all(write(samples)); }
  std::unique_ptr<Recording> open(const std::vector<BagSample>& samples, const RecordingOptions& options = {}) const {
    auto recording = open_recording(write(samples), options);
    EXPECT_TRUE(recording) << recording.error().message;
    return recording ? std::move(*recording) : nullptr;
  }

  TemporaryFolder folder_;
};
INSTANTIATE_TEST_SUITE_P(Bags, EveryBag,
                         testing::Values(BagKind{"sqlite", Storage::kSqlite, ""}, BagKind{"mcap", Storage::kMcap, ""},
                                         BagKind{"mcap_lz4", Storage::kMcap, "lz4"},
                                         BagKind{"mcap_zstd", Storage::kMcap, "zstd"},
                                         BagKind{"ros1", Storage::kRos1, "none"},
                                         BagKind{"ros1_bz2", Storage::kRos1, "bz2"},
                                         BagKind{"ros1_lz4", Storage::kRos1, "lz4"}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(EveryBag, GivesScansAndOdometryInTheOrderOfReception) {
  const auto recording = open(robot(wire()));
  ASSERT_NE(recording, nullptr);
  const RecordingInfo& info = recording->info();
  EXPECT_EQ(info.format, ros1() ? "ros1" : "ros2");
  ASSERT_EQ(info.sensors.size(), 2U);
  EXPECT_EQ(info.sensors.at("laser0").messages, 10U);
  EXPECT_EQ(info.sensors.at("odom0").last_stamp, at(9));
  const LaserCalibration& laser = info.calibration.lasers.at("laser0");
  EXPECT_NEAR(laser.T_base_laser.translation.x(), 0.3, 1e-12) << "by way of the deck";
  EXPECT_NEAR(laser.T_base_laser.translation.y(), 0.05, 1e-12);
  EXPECT_NEAR(to_pose2(laser.T_base_laser).theta, 0.5, 1e-12);
  EXPECT_EQ(laser.beams, 4);
  EXPECT_THAT(info.notes, Contains(HasSubstr("laser0 is /scan")));
  EXPECT_THAT(info.notes, Contains(HasSubstr("/battery (sensor_msgs/BatteryState, 10 messages)")));

  const Contents contents = read_all(*recording);
  EXPECT_TRUE(contents.rejected.empty());
  ASSERT_EQ(contents.messages.size(), 20U);
  const auto* odometry = std::get_if<WheelOdometry>(&contents.messages[2]);
  ASSERT_NE(odometry, nullptr);
  EXPECT_NEAR(odometry->pose.x, 0.1, 1e-12);
  EXPECT_EQ(odometry->forward_speed, 1.0);
  const auto* scan = std::get_if<LaserScan>(&contents.messages[3]);
  ASSERT_NE(scan, nullptr);
  EXPECT_EQ(scan->stamp, at(1));
  EXPECT_THAT(scan->ranges, ElementsAre(1.0F, 2.0F, 3.0F, 4.0F));
}

TEST_P(EveryBag, SortsWhatWasStoredTopicByTopic) {
  auto samples = robot(wire());
  std::stable_sort(samples.begin(), samples.end(), [](const auto& a, const auto& b) { return a.topic < b.topic; });
  const Contents contents = read(samples);
  ASSERT_EQ(contents.messages.size(), 20U);
  for (std::size_t i = 2; i < 20; ++i) EXPECT_EQ(stamp_of(contents.messages[i]), at(static_cast<int>(i / 2)));
}

TEST_P(EveryBag, KeepsTheMotionCaptureForTheEvaluation) {
  const auto truth = read_ground_truth(write(robot(wire())));
  ASSERT_TRUE(truth) << truth.error().message;
  ASSERT_EQ(truth->size(), 10U);
  EXPECT_EQ(truth->back().stamp, at(9));
  EXPECT_NEAR(truth->back().pose.y, 5.0, 1e-12);
}

TEST_P(EveryBag, ReadsRangesByTheRosConventions) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  SampleScan scan;
  scan.stamp = at(0);
  scan.angle_increment = 0.1F;
  scan.ranges = {kInf, -kInf, kNan, 0.0F, 0.05F, 10.5F, 5.0F, -1.0F};
  const Contents contents = read({{"/scan", "sensor_msgs/LaserScan", at(0), scan_message(wire(), scan)}});
  ASSERT_EQ(contents.messages.size(), 1U);
  const auto& ranges = std::get<LaserScan>(contents.messages[0]).ranges;
  ASSERT_EQ(ranges.size(), 8U);
  for (const int none : {1, 2, 3, 4, 7}) EXPECT_TRUE(std::isnan(ranges[static_cast<std::size_t>(none)])) << none;
  for (const int beyond : {0, 5}) EXPECT_EQ(ranges[static_cast<std::size_t>(beyond)], kInf) << beyond;
  EXPECT_EQ(ranges[6], 5.0F);
}

TEST_P(EveryBag, TellsWhenTheMountingIsNotKnown) {
  const auto recording = open({{"/scan", "sensor_msgs/LaserScan", at(0), scan_message(wire(), {at(0), "velodyne"})}});
  ASSERT_NE(recording, nullptr);
  EXPECT_TRUE(recording->info().calibration.lasers.at("laser0").T_base_laser.translation.isZero());
  EXPECT_THAT(recording->info().notes, Contains(HasSubstr("no transform between base_link and velodyne")));
}

TEST_P(EveryBag, TakesTheOdometryFromTfWhereThereIsNoTopic) {
  std::vector<BagSample> samples = robot(wire());
  std::erase_if(samples, [](const BagSample& sample) { return sample.topic == "/odom"; });
  for (int tick = 0; tick < 10; ++tick) {
    for (int again = 0; again < 2; ++again) {  // tf repeats itself
      samples.push_back({"/tf", "tf2_msgs/TFMessage", at(tick) + again,
                         transforms_message(wire(), at(tick),
                                            {{"map", "odom", planar(7, 7, 0)},
                                             {"odom", "base_footprint", planar(0.1 * tick, 1.0, 0.0)},
                                             {"base_footprint", "base_link", planar(0.0, 0.5, 0.0)}})});
    }
  }
  const auto recording = open(samples);
  ASSERT_NE(recording, nullptr);
  EXPECT_EQ(recording->info().sensors.at("odom0").kind, SensorKind::kOdometry);
  EXPECT_THAT(recording->info().notes, Contains(HasSubstr("odom0 is the move of base_footprint in odom")));
  const Contents contents = read_all(*recording);
  EXPECT_TRUE(contents.rejected.empty());
  EXPECT_EQ(contents.count("odom0"), 10U);
  for (const SensorMessage& message : contents.messages) {
    if (const auto* odometry = std::get_if<WheelOdometry>(&message)) {
      EXPECT_NEAR(odometry->pose.y, 1.5, 1e-9);
    }
  }
}

TEST_P(EveryBag, LetsTopicsBeChosen) {
  std::vector<BagSample> samples = robot(wire());
  SampleScan rear;
  rear.frame = "rear";
  for (int tick = 0; tick < 5; ++tick) {
    rear.stamp = at(tick);
    samples.push_back({"/rear/scan", "sensor_msgs/LaserScan", at(tick) + 5, scan_message(wire(), rear)});
  }
  const auto all = open(samples);
  ASSERT_NE(all, nullptr);
  EXPECT_EQ(all->info().sensors.at("laser0").messages, 10U) << "the one with more messages";
  EXPECT_EQ(all->info().sensors.at("laser1").messages, 5U);

  const auto chosen = open(samples, {{{"laser0", "/rear/scan"}, {"odom0", "none"}}, "laser"});
  ASSERT_NE(chosen, nullptr);
  ASSERT_EQ(chosen->info().sensors.size(), 1U);
  EXPECT_EQ(chosen->info().sensors.at("laser0").messages, 5U);

  const auto path = write(samples);
  const auto wrong_name = open_recording(path, {{{"laser0", "/nowhere"}}, ""});
  ASSERT_FALSE(wrong_name);
  EXPECT_EQ(wrong_name.error().kind, ErrorKind::kUsage);
  EXPECT_THAT(wrong_name.error().message,
              HasSubstr("laser0: /nowhere is not in the recording (possible here: /scan, /rear/scan)"));
  const auto wrong_type = open_recording(path, {{{"laser0", "/odom"}}, ""});
  ASSERT_FALSE(wrong_type);
  EXPECT_THAT(wrong_type.error().message, HasSubstr("is of type nav_msgs/Odometry"));
  const auto wrong_role = open_recording(path, {{{"sonar0", "/scan"}}, ""});
  ASSERT_FALSE(wrong_role);
  EXPECT_THAT(wrong_role.error().message, HasSubstr("known are laserN, odom0, camN and truth"));
  const auto second_odometry = open_recording(path, {{{"odom0", "/odom"}, {"odom1", "/odom"}}, ""});
  ASSERT_FALSE(second_odometry);
  EXPECT_THAT(second_odometry.error().message, HasSubstr("topic of odom1: known are laserN, odom0"));
  const auto other_truth = read_ground_truth(path, {{{"truth", "/odom"}}, ""});
  ASSERT_TRUE(other_truth) << other_truth.error().message;
  EXPECT_NEAR(other_truth->back().pose.y, 0.0, 1e-12);
}

TEST_P(EveryBag, NeverTakesTheTruthForOdometry) {
  std::vector<BagSample> samples = robot(wire());
  std::erase_if(samples, [](const BagSample& sample) { return sample.topic == "/odom"; });
  samples.push_back({"/ground_truth/odom", "nav_msgs/Odometry", at(9),
                     odometry_message(wire(), at(9), "base_link", planar(0, 0, 0))});
  const auto recording = open(samples);
  ASSERT_NE(recording, nullptr);
  EXPECT_FALSE(recording->info().sensors.contains("odom0"));
}

TEST_P(EveryBag, ReadsImagesWithTheirCalibration) {
  std::vector<BagSample> samples;
  std::string red_green_blue;
  for (int pixel = 0; pixel < 16 * 12; ++pixel) red_green_blue += std::string("\xFF\x00\x00", 3);
  samples.push_back({"/front/camera_info", "sensor_msgs/CameraInfo", at(0), camera_info_message(wire(), 16, 12, 20.0)});
  samples.push_back({"/left/camera_info", "sensor_msgs/CameraInfo", at(0), camera_info_message(wire(), 16, 12, 21.0)});
  for (int tick = 0; tick < 3; ++tick) {
    samples.push_back({"/front/image_raw", "sensor_msgs/Image", at(tick),
                       image_message(wire(), at(tick), "rgb8", 16, 12, red_green_blue)});
    samples.push_back({"/front/image_raw/compressed", "sensor_msgs/CompressedImage", at(tick),
                       compressed_image_message(wire(), at(tick), encoded_image(".jpg", 1))});
    samples.push_back({"/left/image_raw/compressed", "sensor_msgs/CompressedImage", at(tick),
                       compressed_image_message(wire(), at(tick), encoded_image(".jpg", tick))});
    samples.push_back({"/depth/image_raw", "sensor_msgs/Image", at(tick),
                       image_message(wire(), at(tick), "16UC1", 16, 12, std::string(16 * 12 * 2, 'a'))});
  }
  samples.push_back({"/front/image_raw", "sensor_msgs/Image", at(5),
                     image_message(wire(), at(5), "rgb8", 8, 12, red_green_blue.substr(0, 8 * 12 * 3))});
  const auto recording = open(samples);
  ASSERT_NE(recording, nullptr);
  ASSERT_EQ(recording->info().sensors.size(), 2U);
  EXPECT_EQ(recording->info().calibration.cameras.at("cam0").fx, 20.0);
  EXPECT_EQ(recording->info().calibration.cameras.at("cam0").k1, -0.1);
  EXPECT_EQ(recording->info().calibration.cameras.at("cam1").fx, 21.0);
  EXPECT_NEAR((recording->info().calibration.cameras.at("cam0").T_base_camera * Eigen::Vector3d::UnitZ()).x(), 1.0,
              1e-9)
      << "looking forward where tf does not tell";
  const Contents contents = read_all(*recording);
  EXPECT_EQ(contents.count("cam0"), 3U);
  EXPECT_EQ(contents.count("cam1"), 3U);
  EXPECT_EQ(std::get<Image>(contents.messages.front()).pixels->front(), 76) << "the luma of red";
  ASSERT_EQ(contents.rejected.size(), 1U);
  EXPECT_THAT(contents.rejected[0].reason, HasSubstr("8x12 pixels, its calibration is for 16x12"));
}

TEST_P(EveryBag, RejectsBadMessagesAndGoesOn) {
  std::vector<BagSample> samples = robot(wire());
  std::size_t scans = 0;
  SampleScan odd;
  for (BagSample& sample : samples) {
    if (sample.topic != "/scan") continue;
    odd.stamp = at(static_cast<int>(scans));
    odd.ranges = {1.0F, 2.0F, 3.0F};
    switch (scans++) {
      case 2:
        sample.data.resize(30);  // cut
        break;
      case 4:
        sample.data = scan_message(wire(), odd);  // of another geometry
        break;
      case 6:
        odd.ranges = {1.0F, 2.0F, 3.0F, 4.0F};
        odd.stamp = at(3);  // from the past
        sample.data = scan_message(wire(), odd);
        break;
      default:
        break;
    }
  }
  const Contents contents = read(samples);
  EXPECT_FALSE(contents.error);
  EXPECT_EQ(contents.count("laser0"), 7U);
  EXPECT_EQ(contents.count("odom0"), 10U);
  ASSERT_EQ(contents.rejected.size(), 3U);
  EXPECT_THAT(contents.rejected[0].reason, HasSubstr("message 3 of /scan: "));
  EXPECT_THAT(contents.rejected[1].reason, HasSubstr("scan of 3 readings"));
  EXPECT_THAT(contents.rejected[2].reason, HasSubstr("steps back"));
}

TEST_P(EveryBag, UsesASweepOnlyWhereTheOrderOfFiringIsKnown) {
  SampleScan scan;
  scan.stamp = at(0);
  scan.time_increment = 0.01F;
  const auto half = open({{"/scan", "sensor_msgs/LaserScan", at(0), scan_message(wire(), scan)}});
  ASSERT_NE(half, nullptr);
  EXPECT_NEAR(half->info().calibration.lasers.at("laser0").sweep_duration, 0.03, 1e-6);

  scan.angle_min = -3.14F;
  scan.angle_increment = 2.0F * 3.14F / 3.0F;
  const auto round = open({{"/scan", "sensor_msgs/LaserScan", at(0), scan_message(wire(), scan)}});
  ASSERT_NE(round, nullptr);
  EXPECT_EQ(round->info().calibration.lasers.at("laser0").sweep_duration, 0.0);
  EXPECT_THAT(round->info().notes, Contains(HasSubstr("--sweep-duration laser0=0.0300 if the first beam")));
}

TEST_P(EveryBag, SurvivesRandomDamage) {
  std::mt19937 random(11);
  const auto file = write_messages(robot(wire()));
  const auto path = ros1() ? file : file.parent_path();
  const std::string whole = read_file(file);
  for (int i = 0; i < 200; ++i) {
    std::string bytes = whole;
    if (i % 4 == 0) {
      bytes.resize(random() % bytes.size());
    } else {
      for (int flips = 0; flips < 8; ++flips) bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    write_file(file, bytes);
    const Contents contents = open_and_read_all(path);
    for (const RejectedMessage& rejected : contents.rejected) EXPECT_GT(rejected.reason.size(), 10U);
    for (const SensorMessage& message : contents.messages) {
      if (const auto* odometry = std::get_if<WheelOdometry>(&message)) {
        EXPECT_TRUE(odometry->pose.is_finite());
      }
    }
  }
}

TEST(Ros1Bag, KeepsWhatStandsBeforeACut) {
  TemporaryFolder folder;
  const auto file = folder.path() / "cut.bag";
  const std::string whole = ros1_bag(robot(Wire::kRos1));
  write_file(file, whole.substr(0, whole.size() / 2));
  const Contents contents = open_and_read_all(file);
  EXPECT_GT(contents.messages.size(), 6U);
  ASSERT_EQ(contents.rejected.size(), 1U);
  EXPECT_THAT(contents.rejected[0].reason, HasSubstr("cut.bag: the chunk at byte "));
}

TEST(Ros1Bag, LosesOneDamagedChunkOnly) {
  TemporaryFolder folder;
  const auto file = folder.path() / "damaged.bag";
  std::string bytes = ros1_bag(robot(Wire::kRos1), "lz4");
  const std::size_t chunk = bytes.find("\x04\x22\x4D\x18", bytes.size() / 2);  // the magic number of LZ4
  ASSERT_NE(chunk, std::string::npos);
  bytes[chunk] = 'x';
  write_file(file, bytes);
  const Contents contents = open_and_read_all(file);
  EXPECT_GE(contents.messages.size(), 17U);
  ASSERT_EQ(contents.rejected.size(), 1U);
  EXPECT_THAT(contents.rejected[0].reason, HasSubstr("lz4 data is damaged"));
}

TEST(Ros1Bag, RefusesUnknownCompression) {
  TemporaryFolder folder;
  write_file(folder.path() / "file.bag", ros1_bag(robot(Wire::kRos1), "zip"));
  const auto recording = open_recording(folder.path() / "file.bag");
  ASSERT_FALSE(recording);
  EXPECT_THAT(recording.error().message, HasSubstr("compression 'zip' (known: none, bz2, lz4, zstd)"));
}

TEST(Ros1Bag, RefusesHugeLengths) {
  TemporaryFolder folder;
  for (const std::string length : {"\xFF\xFF\xFF\xFF", "\xFF\xFF\x0F\x10"}) {
    write_file(folder.path() / "file.bag", "#ROSBAG V2.0\n" + length + "some bytes");
    const auto recording = open_recording(folder.path() / "file.bag");
    ASSERT_FALSE(recording);
    EXPECT_EQ(recording.error().kind, ErrorKind::kInvalidInput);
  }
}

TEST(Ros2Bag, OpensTheFileAloneAndTheFolderWithoutMetadata) {
  TemporaryFolder folder;
  const auto file = write_ros2_bag(folder.path() / "bag", robot(Wire::kCdr));
  EXPECT_EQ(open_and_read_all(file).messages.size(), 20U);
  std::filesystem::remove(folder.path() / "bag/metadata.yaml");
  EXPECT_EQ(open_and_read_all(folder.path() / "bag").messages.size(), 20U);
}

TEST(Ros2Bag, ReadsMessagesOfEitherByteOrder) {
  TemporaryFolder folder;
  write_ros2_bag(folder.path() / "bag", robot(Wire::kBigEndianCdr));
  const Contents contents = open_and_read_all(folder.path() / "bag");
  EXPECT_EQ(contents.messages.size(), 20U);
  EXPECT_TRUE(contents.rejected.empty());
}

TEST(Ros2Bag, SaysWhatItCannotRead) {
  TemporaryFolder folder;
  const auto bag = folder.path() / "bag";
  write_ros2_bag(bag, robot(Wire::kCdr));
  const std::string metadata = read_file(bag / "metadata.yaml");
  const auto refused_with = [&](const std::string& from, const std::string& to) {
    std::string changed = metadata;
    changed.replace(changed.find(from), from.size(), to);
    write_file(bag / "metadata.yaml", changed);
    const auto recording = open_recording(bag);
    EXPECT_FALSE(recording);
    return recording ? std::string() : recording.error().message;
  };
  EXPECT_THAT(refused_with("sqlite3", "tape"), HasSubstr("storage_identifier is 'tape' (known: sqlite3, mcap)"));
  EXPECT_THAT(refused_with("compression_mode: \"\"", "compression_mode: FILE"),
              HasSubstr("compression_mode is 'FILE'"));
  EXPECT_THAT(refused_with("bag_0.db3", "bag_7.db3"), HasSubstr("bag_7.db3: cannot be opened"));
  EXPECT_THAT(refused_with("rosbag2_bagfile_information", "other"),
              HasSubstr("rosbag2_bagfile_information is missing"));
  EXPECT_THAT(refused_with("relative", ": ["), HasSubstr("metadata.yaml: "));
}

TEST(Ros2Bag, TellsACutFile) {
  TemporaryFolder folder;
  const auto file = write_ros2_bag(folder.path() / "bag", robot(Wire::kCdr));
  const std::string whole = read_file(file);
  write_file(file, whole.substr(0, whole.size() / 2));
  const Contents contents = open_and_read_all(file);
  if (contents.error) {
    EXPECT_THAT(contents.error->message, HasSubstr("bag_0.db3"));
  } else {
    ASSERT_FALSE(contents.rejected.empty());
    EXPECT_THAT(contents.rejected.back().reason, HasSubstr("damaged or cut"));
  }
}

TEST(McapBag, OpensTheFileAloneAndTheFolderWithoutMetadata) {
  TemporaryFolder folder;
  const auto file = write_mcap_bag(folder.path() / "bag", robot(Wire::kCdr), "zstd");
  EXPECT_EQ(open_and_read_all(file).messages.size(), 20U);
  std::filesystem::remove(folder.path() / "bag/metadata.yaml");
  EXPECT_EQ(open_and_read_all(folder.path() / "bag").messages.size(), 20U);
  // A bag that was split: each file names its topics anew.
  write_file(folder.path() / "bag/bag_1.mcap", mcap_file(robot(Wire::kCdr)));
  EXPECT_EQ(open_recording(folder.path() / "bag").value()->info().sensors.at("laser0").messages, 20U);
}

TEST(McapBag, KeepsWhatStandsBeforeACut) {
  TemporaryFolder folder;
  const auto file = folder.path() / "cut.mcap";
  const std::string whole = mcap_file(robot(Wire::kCdr));
  write_file(file, whole.substr(0, whole.size() / 2));
  const Contents contents = open_and_read_all(file);
  EXPECT_GT(contents.messages.size(), 6U);
  ASSERT_FALSE(contents.rejected.empty());
  EXPECT_THAT(contents.rejected.back().reason, HasSubstr("cut.mcap: the record at byte "));
}

TEST(McapBag, LosesOneDamagedChunkOnly) {
  for (const std::string compression : {"", "lz4", "zstd"}) {
    TemporaryFolder folder;
    const auto file = folder.path() / "damaged.mcap";
    std::string bytes = mcap_file(robot(Wire::kCdr), compression);
    const std::size_t in_chunk = bytes.find(compression.empty() ? "whatever" : compression, bytes.size() / 2);
    ASSERT_NE(in_chunk, std::string::npos);
    const std::size_t inside = in_chunk + (compression.empty() ? 0 : 60);
    bytes[inside] = static_cast<char>(bytes[inside] + 1);
    write_file(file, bytes);
    const Contents contents = open_and_read_all(file);
    EXPECT_GE(contents.messages.size(), 16U) << compression;
    ASSERT_EQ(contents.rejected.size(), 1U) << compression;
    EXPECT_THAT(contents.rejected[0].reason, HasSubstr("the chunk at byte ")) << compression;
  }
}

TEST(McapBag, SaysWhatItCannotRead) {
  TemporaryFolder folder;
  const auto file = folder.path() / "file.mcap";
  write_file(file, mcap_file(robot(Wire::kCdr), "none"));
  EXPECT_EQ(open_and_read_all(file).messages.size(), 20U);
  std::string bytes = mcap_file(robot(Wire::kCdr), "lz4");
  for (std::size_t at = 0; (at = bytes.find("lz4", at)) != std::string::npos;) bytes.replace(at, 3, "zip");
  write_file(file, bytes);
  const auto zipped = open_recording(file);
  ASSERT_FALSE(zipped);
  EXPECT_THAT(zipped.error().message, HasSubstr("compression 'zip' (known: none, bz2, lz4, zstd)"));
  write_file(file, "this is no MCAP file");
  const auto text = open_recording(file);
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().kind, ErrorKind::kInvalidInput);
}

TEST(RecordingOptions, AreForBagsOnly) {
  TemporaryFolder folder;
  write_euroc_sample(folder.path());
  const auto recording = open_recording(folder.path(), {{{"laser0", "/scan"}}, ""});
  ASSERT_FALSE(recording);
  EXPECT_EQ(recording.error().kind, ErrorKind::kUsage);
}

TEST(RosRecording, OfTheJackalIsTheSameFromBothBags) {
  const char* root = std::getenv("SLAMFUSE_RECORDINGS");
  if (root == nullptr || *root == '\0') GTEST_SKIP() << "SLAMFUSE_RECORDINGS is not set: needs real/jackal";
  const std::filesystem::path folder = std::filesystem::path(root) / "real/jackal";
  const Contents ros1 = open_and_read_all(folder / "test_2026-02-17-15-54-31.bag");
  const Contents ros2 = open_and_read_all(folder / "test_2026-02-17-15-54-31");
  EXPECT_EQ(ros1.count("laser0"), 414U);
  ASSERT_EQ(ros1.messages.size(), ros2.messages.size());
  for (std::size_t i = 0; i < ros1.messages.size(); ++i) {
    const auto& first = std::get<LaserScan>(ros1.messages[i]);
    const auto& second = std::get<LaserScan>(ros2.messages[i]);
    ASSERT_EQ(first.stamp, second.stamp);
    ASSERT_EQ(first.ranges, second.ranges);
  }
  const auto truth = read_ground_truth(folder / "test_2026-02-17-15-54-31");
  ASSERT_TRUE(truth) << truth.error().message;
  EXPECT_EQ(truth->size(), 4734U);
}

}  // namespace
}  // namespace slamfuse::common
