// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/private_domain.hpp"
#include "idl/reader.hpp"
#include "idl/writer.hpp"

namespace slamfuse::idl {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 5s;  // far above what loopback takes, far below a test's time limit

// Two participants of one private domain.
class PubSub : public testing::Test {
 protected:
  PrivateDomain domain_;
  Participant sender_ = Participant::create(domain_.settings()).value();
  Participant receiver_ = Participant::create(domain_.settings()).value();
};

Message<PoseStamped> pose_at(double x) {
  Message<PoseStamped> message;
  assign(message->header.frame_id, "map");
  message->header.stamp = {1700000000, 5000000};
  message->pose.position.x = x;
  message->pose.orientation.w = 1.0;
  return message;
}

TEST_F(PubSub, DeliversMessagesInOrderAndComplete) {
  auto writer = Writer<PoseStamped>::create(sender_, "pose", QosProfile::kOutput).value();
  auto reader = Reader<PoseStamped>::create(receiver_, "pose", QosProfile::kCommandInput).value();
  ASSERT_TRUE(writer.wait_for_reader(kPatience));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(writer.write(pose_at(i)));
  for (int i = 0; i < 5; ++i) {
    const auto taken = reader.take(kPatience);
    ASSERT_TRUE(taken && *taken);
    EXPECT_EQ((**taken)->pose.position.x, i);
    EXPECT_EQ(text_of((**taken)->header.frame_id), "map");
    EXPECT_EQ((**taken)->header.stamp.nanosec, 5000000u);
  }
}

TEST_F(PubSub, GivesNothingWithinTheTimeoutWhenNobodyWrites) {
  auto reader = Reader<PoseStamped>::create(receiver_, "pose", QosProfile::kCommandInput).value();
  const auto started = std::chrono::steady_clock::now();
  const auto taken = reader.take(50ms);
  const auto waited = std::chrono::steady_clock::now() - started;
  ASSERT_TRUE(taken);
  EXPECT_FALSE(*taken);
  EXPECT_GE(waited, 45ms);
  EXPECT_LT(waited, kPatience);
}

TEST_F(PubSub, ReportsThatNobodyListens) {
  auto writer = Writer<PoseStamped>::create(sender_, "pose", QosProfile::kOutput).value();
  EXPECT_FALSE(writer.wait_for_reader(20ms));
  EXPECT_EQ(writer.matched_readers(), 0);
  EXPECT_TRUE(writer.write(pose_at(1.0)));
  EXPECT_TRUE(writer.wait_for_acknowledgments(1s));
}

TEST_F(PubSub, HandsALatchedMessageToALateReader) {
  auto writer = Writer<OccupancyGrid>::create(sender_, "map", QosProfile::kLatchedOutput).value();
  for (const std::int8_t value : {std::int8_t{0}, std::int8_t{-1}}) {
    Message<OccupancyGrid> grid;
    allocate(grid->data, 200000);  // many network packets
    for (std::size_t i = 0; i < 200000; ++i) grid->data._buffer[i] = value;
    ASSERT_TRUE(writer.write(grid));
  }
  auto reader = Reader<OccupancyGrid>::create(receiver_, "map", QosProfile::kLatchedOutput).value();
  const auto taken = reader.take(kPatience);
  ASSERT_TRUE(taken && *taken);
  ASSERT_EQ((**taken)->data._length, 200000u);
  EXPECT_EQ((**taken)->data._buffer[0], -1) << "the latest of the two";
  EXPECT_EQ((**taken)->data._buffer[199999], -1);
}

TEST_F(PubSub, LetsABestEffortSensorReaderHearAReliableWriter) {
  auto writer = Writer<LaserScan>::create(sender_, "scan", QosProfile::kOutput).value();
  auto reader = Reader<LaserScan>::create(receiver_, "scan", QosProfile::kSensorInput).value();
  EXPECT_TRUE(writer.wait_for_reader(kPatience));
}

TEST_F(PubSub, DoesNotTakeTheEndOfAWriterForAMessage) {
  auto reader = Reader<PoseStamped>::create(receiver_, "pose", QosProfile::kCommandInput).value();
  {
    auto writer = Writer<PoseStamped>::create(sender_, "pose", QosProfile::kOutput).value();
    ASSERT_TRUE(writer.wait_for_reader(kPatience));
    ASSERT_TRUE(writer.write(pose_at(1.0)));
    ASSERT_TRUE(writer.wait_for_acknowledgments(kPatience));
  }
  const auto first = reader.take(kPatience);
  ASSERT_TRUE(first && *first);
  const auto second = reader.take(200ms);
  ASSERT_TRUE(second);
  EXPECT_FALSE(*second);
}

TEST_F(PubSub, RefusesATopicNameThatDdsDoesNotAllow) {
  const auto writer = Writer<PoseStamped>::create(sender_, "no spaces", QosProfile::kOutput);
  ASSERT_FALSE(writer);
  EXPECT_THAT(writer.error().message, testing::HasSubstr("rt/no spaces"));
}

TEST(Participant, RefusesABrokenCycloneConfigurationAndSaysWhatIsWrongWithIt) {
  const ScopedEnvironment broken("CYCLONEDDS_URI", "<CycloneDDS><Domain><NoSuchThing/></Domain></CycloneDDS>");
  const auto participant = Participant::create({78, true});
  ASSERT_FALSE(participant);
  EXPECT_THAT(participant.error().message, testing::HasSubstr("domain 78"));
  EXPECT_THAT(participant.error().message, testing::HasSubstr("NoSuchThing: unknown element"));
}

TEST(Participant, TakesNoSampleAboveTheLimit) {
  const ScopedEnvironment limit(
      "CYCLONEDDS_URI", ("<CycloneDDS><Domain><Internal><MaxSampleSize>1MB</MaxSampleSize></Internal><Discovery><Tag>" +
                         std::to_string(getpid()) + "</Tag></Discovery></Domain></CycloneDDS>")
                            .c_str());
  const auto sender = Participant::create({78, true}).value();
  const auto receiver = Participant::create({78, true}).value();
  auto writer = Writer<Image>::create(sender, "image", QosProfile::kOutput).value();
  auto reader = Reader<Image>::create(receiver, "image", QosProfile::kTransformInput).value();
  ASSERT_TRUE(writer.wait_for_reader(5s));
  for (const std::size_t size : {2'000'000UL, 500'000UL}) {
    Message<Image> image;
    allocate(image->data, size);
    static_cast<void>(writer.write(image));  // the sender has the same limit
  }
  const auto taken = reader.take(5s);
  ASSERT_TRUE(taken && *taken);
  EXPECT_EQ((**taken)->data._length, 500'000u);
}

TEST(Participant, OfOneProcessAgreeOnTheNetwork) {
  const auto first = Participant::create({79, true});
  ASSERT_TRUE(first);
  EXPECT_FALSE(Participant::create({79, false}));
}

}  // namespace
}  // namespace slamfuse::idl
