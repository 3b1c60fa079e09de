// SPDX-License-Identifier: BSD-3-Clause
#include "idl/domain_settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/ros_name.hpp"
#include "idl/scoped_environment.hpp"

namespace slamfuse::idl {
namespace {

class DomainFromEnvironment : public testing::Test {
 protected:
  ScopedEnvironment id_{"ROS_DOMAIN_ID", nullptr};
  ScopedEnvironment localhost_{"ROS_LOCALHOST_ONLY", nullptr};
  ScopedEnvironment range_{"ROS_AUTOMATIC_DISCOVERY_RANGE", nullptr};
};

TEST_F(DomainFromEnvironment, IsDomainZeroWhenNothingIsSet) {
  const auto settings = domain_from_environment(Network::kAll);
  ASSERT_TRUE(settings);
  EXPECT_EQ(settings->id, 0u);
  EXPECT_FALSE(settings->loopback_only);
}

TEST_F(DomainFromEnvironment, CannotWidenTheNetwork) {
  const ScopedEnvironment localhost("ROS_LOCALHOST_ONLY", "0");
  const ScopedEnvironment range("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET");
  EXPECT_TRUE(domain_from_environment(Network::kLoopback)->loopback_only);
}

TEST_F(DomainFromEnvironment, HonoursWhatRosNodesHonour) {
  const ScopedEnvironment id("ROS_DOMAIN_ID", "42");
  const ScopedEnvironment localhost("ROS_LOCALHOST_ONLY", "1");
  const auto settings = domain_from_environment(Network::kAll);
  ASSERT_TRUE(settings);
  EXPECT_EQ(settings->id, 42u);
  EXPECT_TRUE(settings->loopback_only);
}

TEST_F(DomainFromEnvironment, StaysOnThisMachineWhenTheDiscoveryRangeIsLocalhost) {
  const ScopedEnvironment range("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST");
  EXPECT_TRUE(domain_from_environment(Network::kAll)->loopback_only);
}

TEST_F(DomainFromEnvironment, RefusesAnIdThatIsNoDomain) {
  for (const char* text : {"-1", "233", "abc", "1x", " 1", "1.0", "99999999999999999999"}) {
    const ScopedEnvironment id("ROS_DOMAIN_ID", text);
    const auto settings = domain_from_environment(Network::kAll);
    ASSERT_FALSE(settings) << text;
    EXPECT_EQ(settings.error().kind, common::ErrorKind::kInvalidInput);
    EXPECT_THAT(settings.error().message, testing::HasSubstr(text));
    EXPECT_THAT(settings.error().message, testing::HasSubstr("0 to 232"));
  }
}

TEST(DdsTopicName, PutsRosTopicsUnderRt) {
  EXPECT_EQ(dds_topic_name("slamfuse/pose"), "rt/slamfuse/pose");
  EXPECT_EQ(dds_topic_name("/scan"), "rt/scan");
}

}  // namespace
}  // namespace slamfuse::idl
