// SPDX-License-Identifier: BSD-3-Clause
#include "service/live_inbox.hpp"

#include <gtest/gtest.h>

#include "idl/writer.hpp"
#include "service/sensor_to_ros.hpp"
#include "service/three_beams.hpp"
#include "system/network.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;

constexpr common::Nanoseconds kStamp = 1'700'000'000'000'000'000;

idl::Message<idl::LaserScan> scan() {
  return to_ros_scan({kStamp, "front"}, {kStamp, "laser0", {1.0F, 2.0F, 3.0F}}, three_beams());
}

class LiveInboxTest : public testing::Test {
 protected:
  std::unique_ptr<LiveInbox> inbox(const LiveInboxOptions& options) {
    return std::make_unique<LiveInbox>(options, participant_, *idl::Publications::create(participant_));
  }
  static InputState state_of(const LiveInbox& inbox, const std::string& topic) {
    for (const InputState& state : inbox.inputs()) {
      if (state.topic == topic) return state;
    }
    return {};
  }

  system::Network network_;
  idl::Participant participant_ = network_.join();
};

TEST_F(LiveInboxTest, TakesMessagesAndKeepsTheBooks) {
  const auto box = inbox({.topics = {{"laser0", "/front/scan"}}});
  ASSERT_TRUE(box->listen());
  auto writer = idl::Writer<idl::LaserScan>::create(participant_, "front/scan", idl::QosProfile::kOutput);
  ASSERT_TRUE(writer && writer->wait_for_reader(10s));
  writer->write(scan());
  const auto arrival = box->take(10s);
  ASSERT_TRUE(arrival);
  EXPECT_EQ(box->sensor_of(arrival->input), "laser0");
  EXPECT_TRUE(std::holds_alternative<idl::Message<idl::LaserScan>>(arrival->payload));
  EXPECT_FALSE(box->take(10ms));
  box->used(arrival->input, kStamp, 7);
  box->dropped(arrival->input);
  box->dropped("laser0");
  box->dropped("cam0");
  EXPECT_EQ(box->rejected(arrival->input, "a reason").rejected, 1u);
  const InputState state = state_of(*box, "front/scan");
  EXPECT_EQ(state.received, 1u);
  EXPECT_EQ(state.writers, 1);
  EXPECT_EQ(state.dropped, 2u);
  EXPECT_EQ(state.last_stamp, kStamp);
  EXPECT_EQ(state.last_rejection, "a reason");
  EXPECT_TRUE(state.required);
}

TEST_F(LiveInboxTest, DropsAndCountsWhatDoesNotFit) {
  const auto box = inbox({.topics = {{"laser0", "scan"}}, .queue_capacity = 2});
  ASSERT_TRUE(box->listen());
  auto writer = idl::Writer<idl::LaserScan>::create(participant_, "scan", idl::QosProfile::kOutput);
  ASSERT_TRUE(writer && writer->wait_for_reader(10s));
  for (int i = 0; i < 5; ++i) {
    writer->write(scan());
    for (int wait = 0; wait < 500 && state_of(*box, "scan").received < static_cast<std::size_t>(i + 1); ++wait) {
      std::this_thread::sleep_for(10ms);
    }
  }
  EXPECT_EQ(state_of(*box, "scan").dropped, 3u);
  EXPECT_TRUE(box->take(1s));
  EXPECT_TRUE(box->take(1s));
  EXPECT_FALSE(box->take(10ms));
}

TEST_F(LiveInboxTest, ListensByDefaultToWhatRobotsHave) {
  LiveInboxOptions options;
  options.cameras = false;
  const auto box = inbox(options);
  ASSERT_TRUE(box->listen());
  std::vector<std::string> topics;
  for (const InputState& state : box->topics()) topics.push_back(state.topic);
  EXPECT_EQ(topics, (std::vector<std::string>{"tf_static", "tf", "odom", "scan"}));
}

TEST_F(LiveInboxTest, RefusesASensorOfNoKnownKind) {
  const auto box = inbox({.topics = {{"sonar0", "sonar"}}});
  const auto listening = box->listen();
  ASSERT_FALSE(listening);
  EXPECT_EQ(listening.error().kind, common::ErrorKind::kUsage);
}

}  // namespace
}  // namespace slamfuse::service
