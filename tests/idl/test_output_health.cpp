// SPDX-License-Identifier: BSD-3-Clause
#include "idl/output_health.hpp"

#include <chrono>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/private_domain.hpp"
#include "idl/reader.hpp"
#include "idl/writer.hpp"

namespace slamfuse::idl {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class OutputHealthTest : public testing::Test {
 protected:
  // The only output, once as many readers are known; else what there is after a while.
  OutputHealth look(std::size_t readers) const {
    for (int i = 0; i < 500; ++i) {
      const auto outputs = outputs_.look();
      if (outputs.size() == 1 && static_cast<std::size_t>(outputs[0].readers) + outputs[0].refused.size() == readers) {
        return outputs[0];
      }
      std::this_thread::sleep_for(10ms);
    }
    const auto outputs = outputs_.look();
    return outputs.empty() ? OutputHealth() : outputs[0];
  }

  PrivateDomain domain_;
  Participant sender_ = Participant::create(domain_.settings()).value();
  Participant receiver_ = Participant::create(domain_.settings()).value();
  Outputs outputs_ = Outputs::create(sender_).value();
};

TEST_F(OutputHealthTest, CountsReadersButNotOurOwn) {
  const auto writer = Writer<PoseStamped>::create(sender_, "pose", QosProfile::kOutput).value();
  const auto own_reader = Reader<PoseStamped>::create(sender_, "pose", QosProfile::kSensorInput).value();
  EXPECT_EQ(look(0).topic, "pose");
  EXPECT_EQ(look(0).type, "geometry_msgs/msg/PoseStamped");
  {
    const auto first = Reader<PoseStamped>::create(receiver_, "pose", QosProfile::kSensorInput).value();
    const auto second = Reader<PoseStamped>::create(receiver_, "pose", QosProfile::kTransformInput).value();
    EXPECT_EQ(look(2).readers, 2);
    EXPECT_TRUE(look(2).refused.empty());
  }
  EXPECT_EQ(look(0).readers, 0);
}

TEST_F(OutputHealthTest, NamesAReaderThatCannotAndWhy) {
  const auto writer = Writer<PoseStamped>::create(sender_, "pose", QosProfile::kOutput).value();
  const auto reader = Reader<PoseStamped>::create(receiver_, "pose", QosProfile::kLatchedOutput).value();
  const auto output = look(1);
  EXPECT_EQ(output.readers, 0);
  ASSERT_EQ(output.refused.size(), 1u);
  EXPECT_EQ(output.refused[0].why, "transient local requested, volatile offered");
  EXPECT_THAT(output.refused[0].who, HasSubstr("test_idl (process " + std::to_string(getpid()) + " on "));
}

TEST_F(OutputHealthTest, NamesTheTypeThatIsExpected) {
  const auto writer = Writer<PoseStamped>::create(sender_, "pose", QosProfile::kOutput).value();
  const auto reader = Reader<Odometry>::create(receiver_, "pose", QosProfile::kSensorInput).value();
  const auto output = look(1);
  ASSERT_EQ(output.refused.size(), 1u);
  EXPECT_EQ(output.refused[0].why, "nav_msgs/msg/Odometry expected, geometry_msgs/msg/PoseStamped published");
}

TEST_F(OutputHealthTest, FollowsWritersThatComeAndGo) {
  EXPECT_TRUE(outputs_.look().empty());
  {
    const auto map = Writer<OccupancyGrid>::create(sender_, "map", QosProfile::kLatchedOutput).value();
    const auto best_effort = Writer<LaserScan>::create(sender_, "scan", QosProfile::kSensorInput).value();
    const auto outputs = outputs_.look();
    ASSERT_EQ(outputs.size(), 2u);
    EXPECT_EQ(outputs[0].topic, "map");
    EXPECT_EQ(outputs[1].topic, "scan");
  }
  EXPECT_TRUE(outputs_.look().empty());
}

}  // namespace
}  // namespace slamfuse::idl
