// SPDX-License-Identifier: BSD-3-Clause
#include "common/ros2_bag_writer.hpp"

#include <set>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include "common/ros_bag.hpp"

namespace slamfuse::common {
namespace {

namespace fs = std::filesystem;

class Ros2BagWriterTest : public testing::Test {
 protected:
  Ros2BagWriterTest() { fs::remove_all(folder_); }
  ~Ros2BagWriterTest() override { fs::remove_all(folder_); }

  // topic, received, first byte behind the header
  using Row = std::tuple<std::string, Nanoseconds, int>;
  static std::vector<Row> read(const fs::path& path) {
    std::vector<Row> rows;
    const auto bag = open_ros2_bag(path);
    EXPECT_TRUE(bag) << bag.error().message;
    if (!bag) return rows;
    std::set<std::size_t> topics;
    for (std::size_t i = 0; i < (*bag)->topics().size(); ++i) topics.insert(i);
    (*bag)->rewind(topics);
    while (const auto item = (*bag)->next()) {
      const auto& message = std::get<RosBagMessage>(*item);
      rows.emplace_back((*bag)->topics()[message.topic].name, message.stored, message.data[4]);
    }
    return rows;
  }

  static std::vector<std::uint8_t> message(int value) {
    return {0, 1, 0, 0, static_cast<std::uint8_t>(value), 0, 0, 0};
  }

  fs::path folder_ = fs::temp_directory_path() / ("slamfuse-bag-" + std::to_string(getpid()));
};

TEST_F(Ros2BagWriterTest, WhatIsWrittenIsReadAgain) {
  {
    const auto bag = Ros2BagWriter::create(folder_).value();
    const auto scan = bag->add_topic({"/scan", "sensor_msgs/msg/LaserScan", "- history: 3\n  depth: 0\n"}).value();
    const auto odom = bag->add_topic({"/odom", "nav_msgs/msg/Odometry", ""}).value();
    ASSERT_TRUE(bag->write(scan, 1000, message(1)));
    ASSERT_TRUE(bag->write(odom, 1000, message(2)));
    ASSERT_TRUE(bag->write(scan, 3000, message(3)));
    EXPECT_EQ(bag->messages(), 3u);
    ASSERT_TRUE(bag->close());
  }
  EXPECT_THAT(read(folder_), testing::ElementsAre(Row("/scan", 1000, 1), Row("/odom", 1000, 2), Row("/scan", 3000, 3)));
  const auto info = YAML::LoadFile((folder_ / "metadata.yaml").string())["rosbag2_bagfile_information"];
  EXPECT_EQ(info["version"].as<int>(), 5);
  EXPECT_EQ(info["storage_identifier"].as<std::string>(), "sqlite3");
  EXPECT_EQ(info["duration"]["nanoseconds"].as<int>(), 2000);
  EXPECT_EQ(info["starting_time"]["nanoseconds_since_epoch"].as<int>(), 1000);
  EXPECT_EQ(info["message_count"].as<int>(), 3);
  const auto topic = info["topics_with_message_count"][0];
  EXPECT_EQ(topic["message_count"].as<int>(), 2);
  EXPECT_EQ(topic["topic_metadata"]["name"].as<std::string>(), "/scan");
  EXPECT_EQ(topic["topic_metadata"]["serialization_format"].as<std::string>(), "cdr");
  EXPECT_EQ(topic["topic_metadata"]["offered_qos_profiles"].as<std::string>(), "- history: 3\n  depth: 0\n");
  EXPECT_EQ(info["relative_file_paths"][0].as<std::string>(), folder_.filename().string() + "_0.db3");
  EXPECT_EQ(info["files"][0]["message_count"].as<int>(), 3);
}

TEST_F(Ros2BagWriterTest, AnEmptyBagIsABag) {
  ASSERT_TRUE(Ros2BagWriter::create(folder_).value()->close());
  EXPECT_THAT(read(folder_), testing::IsEmpty());
}

TEST_F(Ros2BagWriterTest, DoesNotTouchWhatIsThere) {
  fs::create_directories(folder_);
  const auto bag = Ros2BagWriter::create(folder_);
  ASSERT_FALSE(bag);
  EXPECT_EQ(bag.error().kind, ErrorKind::kUsage);
  EXPECT_TRUE(fs::is_empty(folder_));
  EXPECT_FALSE(Ros2BagWriter::create("/proc/no/such/bag"));
}

}  // namespace
}  // namespace slamfuse::common
