// SPDX-License-Identifier: BSD-3-Clause
#include "idl/ros_graph.hpp"

#include <chrono>

#include <dds/dds.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/private_domain.hpp"
#include "idl/raw_reader.hpp"
#include "idl/reader.hpp"
#include "idl/writer.hpp"

namespace slamfuse::idl {
namespace {

using namespace std::chrono_literals;

TEST(ParticipantEntitiesInfo, IsAsRmwDdsCommonReadsIt) {
  const std::string participant(16, 'P');
  const std::string reader(16, 'R');
  const std::string writer(16, 'W');
  const auto iron =
      participant_entities_info(participant, {{}, "node"}, {reader}, {writer, writer}, RosGraph::kFromIron);
  // header, gid, nodes, "/" (length 2, then padding), "node" (length 5), readers, writers
  EXPECT_EQ(iron.size(), 4u + 16 + 4 + (4 + 2) + 2 + (4 + 5) + 3 + 4 + 16 + 4 + 2 * 16);
  const std::string text(iron.begin(), iron.end());
  EXPECT_EQ(text.substr(4, 16), participant);
  EXPECT_EQ(text.substr(28, 2), std::string("/\0", 2));
  EXPECT_EQ(text.substr(36, 5), std::string("node\0", 5));
  const auto humble =
      participant_entities_info(participant, {{}, "node"}, {reader}, {writer, writer}, RosGraph::kUpToHumble);
  EXPECT_EQ(humble.size(), iron.size() + 4 * 8);
  const auto inside = participant_entities_info(participant, {RosNamespace::create("robot").value(), "node"}, {reader},
                                                {writer, writer}, RosGraph::kFromIron);
  EXPECT_EQ(std::string(inside.begin(), inside.end()).substr(28, 7), std::string("/robot\0", 7));
}

TEST(GraphPresence, TellsTheEndpointsThatThereAre) {
  const PrivateDomain domain;
  const auto ours = Participant::create(domain.settings()).value();
  const auto theirs = Participant::create(domain.settings()).value();
  auto graph = RawReader::create_on(theirs, "ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
                                    {.reliable = true, .transient_local = true})
                   .value();
  auto presence = GraphPresence::create(ours, {{}, "slamfuse"}, RosGraph::kFromIron).value();
  ASSERT_TRUE(presence.update());
  const auto before = graph.take(5s).value();
  ASSERT_TRUE(before);
  const auto reader = Reader<LaserScan>::create(ours, "scan", QosProfile::kSensorInput).value();
  const auto writer = Writer<Path>::create(ours, "path", QosProfile::kOutput).value();
  ASSERT_TRUE(presence.update());
  const auto after = graph.take(5s).value();
  ASSERT_TRUE(after);
  EXPECT_EQ(after->size(), before->size() + 2 * 16);
  ASSERT_TRUE(presence.update());
  EXPECT_FALSE(graph.take(100ms).value()) << "nothing new was told";
}

TEST(GraphPresence, CanBeOff) {
  const PrivateDomain domain;
  const auto participant = Participant::create(domain.settings()).value();
  auto graph =
      RawReader::create_on(participant, "ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
                           {.reliable = true, .transient_local = true})
          .value();
  auto presence = GraphPresence::create(participant, {{}, "slamfuse"}, RosGraph::kNone).value();
  ASSERT_TRUE(presence.update());
  EXPECT_FALSE(graph.take(100ms).value());
}

}  // namespace
}  // namespace slamfuse::idl
