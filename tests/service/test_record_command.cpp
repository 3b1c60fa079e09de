// SPDX-License-Identifier: BSD-3-Clause
#include "service/record_command.hpp"

#include <chrono>
#include <future>
#include <set>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "common/ros_bag.hpp"
#include "idl/private_domain.hpp"
#include "idl/raw_writer.hpp"
#include "idl/writer.hpp"
#include "service/temporary_folder.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;

class RecordTest : public testing::Test {
 protected:
  // Runs until `publish` is done and all was taken.
  template <class Publish>
  common::Result<std::string> record(RecordRequest request, const Publish& publish) {
    request.out = folder_.path() / "bag";
    std::atomic<bool> stop{false};
    auto outcome = std::async(std::launch::async, [&] {
      return run_record(
          request, [](const std::string&) {}, stop, [] {});
    });
    publish();
    std::this_thread::sleep_for(300ms);
    stop = true;
    return outcome.get();
  }

  std::vector<std::pair<std::string, std::vector<std::uint8_t>>> recorded() {
    std::vector<std::pair<std::string, std::vector<std::uint8_t>>> messages;
    const auto bag = common::open_ros2_bag(folder_.path() / "bag");
    EXPECT_TRUE(bag) << bag.error().message;
    std::set<std::size_t> topics;
    for (std::size_t i = 0; i < (*bag)->topics().size(); ++i) topics.insert(i);
    (*bag)->rewind(topics);
    while (const auto item = (*bag)->next()) {
      const auto& message = std::get<common::RosBagMessage>(*item);
      messages.emplace_back((*bag)->topics()[message.topic].name,
                            std::vector<std::uint8_t>(message.data.begin(), message.data.end()));
    }
    return messages;
  }

  idl::PrivateDomain domain_;
  idl::ScopedEnvironment id_{"ROS_DOMAIN_ID", "77"};
  idl::Participant participant_ = idl::Participant::create(domain_.settings()).value();
  TemporaryFolder folder_;
};

TEST_F(RecordTest, KeepsEveryMessageOfEveryTypeAsItCame) {
  constexpr int kMessages = 500;
  auto odd = idl::RawWriter::create(participant_, "odd", "some_msgs/msg/Odd", idl::QosProfile::kOutput).value();
  auto latched =
      idl::RawWriter::create(participant_, "map", "some_msgs/msg/Map", idl::QosProfile::kLatchedOutput).value();
  ASSERT_TRUE(latched.write(std::vector<std::uint8_t>{0, 1, 0, 0, 42, 0, 0, 0}));
  const auto outcome = record({}, [&] {
    for (int i = 0; i < 500 && odd.matched_readers() == 0; ++i) std::this_thread::sleep_for(10ms);
    for (int i = 0; i < kMessages; ++i) {
      ASSERT_TRUE(odd.write(std::vector<std::uint8_t>{0, 1, 0, 0, static_cast<std::uint8_t>(i), 0, 0, 0}));
    }
    EXPECT_TRUE(odd.wait_for_acknowledgments(5s));
  });
  ASSERT_TRUE(outcome) << outcome.error().message;
  EXPECT_THAT(*outcome, testing::HasSubstr("recorded 501 messages of 2 topics"));
  int odd_ones = 0;
  for (const auto& [topic, data] : recorded()) {
    if (topic == "/map") {
      EXPECT_EQ(data[4], 42);
    } else {
      EXPECT_EQ(data[4], static_cast<std::uint8_t>(odd_ones++));
    }
  }
  EXPECT_EQ(odd_ones, kMessages);
}

TEST_F(RecordTest, OnlyWhatIsWanted) {
  const auto unwanted =
      idl::RawWriter::create(participant_, "odd", "some_msgs/msg/Odd", idl::QosProfile::kOutput).value();
  auto wanted =
      idl::RawWriter::create(participant_, "map", "some_msgs/msg/Map", idl::QosProfile::kLatchedOutput).value();
  ASSERT_TRUE(wanted.write(std::vector<std::uint8_t>{0, 1, 0, 0, 1, 0, 0, 0}));
  RecordRequest request;
  request.topics = {"/map", "silent"};
  const auto outcome = record(request, [&] {
    for (int i = 0; i < 500 && wanted.matched_readers() == 0; ++i) std::this_thread::sleep_for(10ms);
  });
  ASSERT_TRUE(outcome);
  EXPECT_THAT(*outcome, testing::HasSubstr("of 1 topics"));
  EXPECT_THAT(*outcome, testing::HasSubstr("silent: nobody published it"));
}

TEST_F(RecordTest, WritesOverNothing) {
  std::filesystem::create_directories(folder_.path() / "bag");
  const auto outcome = record({}, [] {});
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().kind, common::ErrorKind::kUsage);
}

TEST(OfferedQosProfiles, AreThoseOfRosbag2) {
  idl::Publication publication;
  publication.reliable = true;
  const auto yaml = YAML::Load(offered_qos_profiles({publication, publication}));
  ASSERT_EQ(yaml.size(), 2u);
  EXPECT_EQ(yaml[0]["reliability"].as<int>(), 1);
  EXPECT_EQ(yaml[0]["durability"].as<int>(), 2);
  EXPECT_EQ(yaml[0]["history"].as<int>(), 3);
  EXPECT_EQ(yaml[0]["deadline"]["sec"].as<long>(), 9223372036);
  EXPECT_FALSE(yaml[0]["avoid_ros_namespace_conventions"].as<bool>());
}

}  // namespace
}  // namespace slamfuse::service
