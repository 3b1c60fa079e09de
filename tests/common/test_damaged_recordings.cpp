// SPDX-License-Identifier: BSD-3-Clause
// Flips bytes in and cuts small recordings at random, with a fixed seed: whatever the damage, reading ends with
// messages, rejected messages or an error that says something, never with a crash, and what it gives is well-formed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "common/recording.hpp"
#include "common/recording_samples.hpp"

namespace slamfuse::common {
namespace {

using namespace samples;

std::string damaged(std::string bytes, std::mt19937& random) {
  if (bytes.empty()) return bytes;
  if (random() % 4 == 0) return bytes.substr(0, random() % bytes.size());
  for (std::size_t flips = 1 + random() % 4; flips > 0; --flips) {
    bytes[random() % bytes.size()] = static_cast<char>(random() % 256);
  }
  return bytes;
}

void expect_well_formed(const Contents& contents) {
  if (contents.error) {
    EXPECT_GT(contents.error->message.size(), 10U);
  }
  for (const RejectedMessage& rejected : contents.rejected) EXPECT_GT(rejected.reason.size(), 10U);
  for (const SensorMessage& message : contents.messages) {
    if (const auto* scan = std::get_if<LaserScan>(&message)) {
      for (const float range : scan->ranges) EXPECT_TRUE(std::isnan(range) || range > 0.0F);
    } else if (const auto* image = std::get_if<Image>(&message)) {
      EXPECT_EQ(image->pixels->size(), static_cast<std::size_t>(image->width * image->height));
    } else if (const auto* odometry = std::get_if<WheelOdometry>(&message)) {
      EXPECT_TRUE(odometry->pose.is_finite());
    }
  }
}

TEST(DamagedRecordings, OfTheEurocLayoutNeverCrash) {
  std::mt19937 random(1);
  TemporaryFolder folder;
  write_euroc_sample(folder.path());
  const std::vector<std::string> files{"odom0/data.csv", "laser0/data.csv",  "laser0/sensor.yaml",
                                       "cam0/data.csv",  "cam0/sensor.yaml", "cam0/data/1700000000400000000.jpg"};
  for (const std::string& file : files) {
    const std::string whole = read_file(folder.path() / file);
    for (int i = 0; i < 150; ++i) {
      write_file(folder.path() / file, damaged(whole, random));
      expect_well_formed(open_and_read_all(folder.path()));
    }
    write_file(folder.path() / file, whole);
  }
  EXPECT_EQ(open_and_read_all(folder.path()).messages.size(), 21U);
}

TEST(DamagedRecordings, OfTheCarmenFormatNeverCrash) {
  std::mt19937 random(2);
  TemporaryFolder folder;
  std::string log = "PARAM robot_frontlaser_offset 0.1 1.0 host 0\n";
  for (int i = 0; i < 5; ++i) {
    log += "FLASER 3 1.5 2.5 81.9 0 0 0 0 0 0 " + std::to_string(i) + ".5 host 0.1\n";
    log += "ROBOTLASER1 0 -1 2 1 10 0.01 0 3 1 1 1 0 0 0 0 0 0 0 0 0 0 0 0 1.0 host 0.7\n";
  }
  for (int i = 0; i < 1000; ++i) {
    write_file(folder.path() / "log.clf", damaged(log, random));
    expect_well_formed(open_and_read_all(folder.path() / "log.clf"));
  }
}

TEST(DamagedRecordings, OfAnyImageFormatNeverCrash) {
  std::mt19937 random(3);
  TemporaryFolder folder;
  write_file(folder.path() / "sensor.yaml", kCameraYaml);
  for (const char* extension : {".jpg", ".png", ".pgm"}) {
    const std::string whole = encoded_image(extension, 1);
    for (int i = 0; i < 300; ++i) {
      write_file(folder.path() / (std::string("image") + extension), damaged(whole, random));
      expect_well_formed(open_and_read_all(folder.path()));
    }
  }
}

TEST(DamagedRecordings, OfRandomBytesAreRefused) {
  std::mt19937 random(4);
  TemporaryFolder folder;
  const std::vector<std::string> heads{"", "BZh9", "\x1F\x8B\x08", "SQLite format 3", "#ROSBAG V2.0\n"};
  for (int i = 0; i < 100; ++i) {
    std::string bytes = heads[static_cast<std::size_t>(i) % heads.size()];
    for (std::size_t size = random() % 500; size > 0; --size) bytes += static_cast<char>(random() % 256);
    write_file(folder.path() / "file", bytes);
    const auto recording = open_recording(folder.path() / "file");
    ASSERT_FALSE(recording);
    EXPECT_EQ(recording.error().kind, ErrorKind::kInvalidInput);
    EXPECT_THAT(recording.error().message, ::testing::HasSubstr("file: "));
  }
}

}  // namespace
}  // namespace slamfuse::common
