// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/private_domain.hpp"
#include "idl/publications.hpp"
#include "idl/raw_reader.hpp"
#include "idl/raw_writer.hpp"
#include "idl/reader.hpp"
#include "idl/writer.hpp"

namespace slamfuse::idl {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 5s;

class RawTest : public testing::Test {
 protected:
  std::vector<Publication> publications_of(const std::string& topic, const Publications& publications) {
    for (int i = 0; i < 500; ++i) {
      std::vector<Publication> found;
      for (auto& publication : publications.look()) {
        if (publication.topic == topic) found.push_back(publication);
      }
      if (!found.empty()) return found;
      std::this_thread::sleep_for(10ms);
    }
    return {};
  }

  PrivateDomain domain_;
  Participant sender_ = Participant::create(domain_.settings()).value();
  Participant receiver_ = Participant::create(domain_.settings()).value();
};

TEST_F(RawTest, WhoPublishesWhatIsKnown) {
  const auto publications = Publications::create(receiver_).value();
  const auto scans = Writer<LaserScan>::create(sender_, "scan", QosProfile::kSensorInput).value();
  const auto maps = Writer<OccupancyGrid>::create(sender_, "map", QosProfile::kLatchedOutput).value();
  const auto scan = publications_of("scan", publications);
  ASSERT_EQ(scan.size(), 1u);
  EXPECT_EQ(scan[0].type, "sensor_msgs/msg/LaserScan");
  EXPECT_FALSE(scan[0].reliable);
  EXPECT_FALSE(scan[0].transient_local);
  EXPECT_FALSE(scan[0].ours);
  const auto map = publications_of("map", publications);
  ASSERT_EQ(map.size(), 1u);
  EXPECT_TRUE(map[0].reliable);
  EXPECT_TRUE(map[0].transient_local);
}

TEST_F(RawTest, MessagesOfAnyTypeComeAsOnTheWireAndGoOutAgain) {
  auto writer = Writer<Image>::create(sender_, "image", QosProfile::kOutput).value();
  auto raw = RawReader::create(receiver_, "image", "sensor_msgs/msg/Image", {.reliable = true}).value();
  ASSERT_TRUE(writer.wait_for_reader(kPatience));
  Message<Image> message;
  assign(message->encoding, "mono8");
  constexpr std::size_t kManyFragments = 300'001;
  allocate(message->data, kManyFragments);
  for (std::size_t i = 0; i < kManyFragments; ++i) message->data._buffer[i] = static_cast<std::uint8_t>(i * i);
  ASSERT_TRUE(writer.write(message));
  const auto bytes = raw.take(kPatience);
  ASSERT_TRUE(bytes && *bytes);
  ASSERT_GT((*bytes)->size(), kManyFragments);
  EXPECT_EQ((**bytes)[0], 0);
  EXPECT_EQ((**bytes)[1], 1);  // CDR, little endian

  auto again = RawWriter::create(receiver_, "again", "sensor_msgs/msg/Image", QosProfile::kOutput).value();
  auto reader = Reader<Image>::create(sender_, "again", QosProfile::kTransformInput).value();
  for (int i = 0; i < 500 && again.matched_readers() == 0; ++i) std::this_thread::sleep_for(10ms);
  ASSERT_TRUE(again.write(**bytes));
  const auto received = reader.take(kPatience);
  ASSERT_TRUE(received && *received);
  EXPECT_EQ(text_of((**received)->encoding), "mono8");
  ASSERT_EQ((**received)->data._length, kManyFragments);
  EXPECT_EQ((**received)->data._buffer[777], static_cast<std::uint8_t>(777 * 777));
}

TEST_F(RawTest, ALateReaderGetsWhatIsLatched) {
  auto writer = RawWriter::create(sender_, "map", "some_msgs/msg/Odd", QosProfile::kLatchedOutput).value();
  const std::vector<std::uint8_t> bytes{0, 1, 0, 0, 7, 0, 0, 0};
  ASSERT_TRUE(writer.write(bytes));
  auto reader =
      RawReader::create(receiver_, "map", "some_msgs/msg/Odd", {.reliable = true, .transient_local = true}).value();
  const auto taken = reader.take(kPatience);
  ASSERT_TRUE(taken && *taken);
  EXPECT_EQ(**taken, bytes);
}

TEST_F(RawTest, OddLengthsArePassedOnWhole) {
  auto writer = RawWriter::create(sender_, "odd", "some_msgs/msg/Odd", QosProfile::kOutput).value();
  auto reader = RawReader::create(receiver_, "odd", "some_msgs/msg/Odd", {.reliable = true}).value();
  for (int i = 0; i < 500 && writer.matched_readers() == 0; ++i) std::this_thread::sleep_for(10ms);
  const std::vector<std::uint8_t> bytes{0, 1, 0, 0, 7, 8, 9};
  ASSERT_TRUE(writer.write(bytes));
  const auto taken = reader.take(kPatience);
  ASSERT_TRUE(taken && *taken);
  EXPECT_THAT(std::vector(taken->value().begin(), taken->value().begin() + 7), testing::ContainerEq(bytes));
  EXPECT_FALSE(writer.write(std::vector<std::uint8_t>{0, 1}));
}

}  // namespace
}  // namespace slamfuse::idl
