// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "idl/entity.hpp"
#include "idl/participant.hpp"
#include "idl/raw_writer.hpp"
#include "idl/ros_namespace.hpp"

namespace slamfuse::idl {

/// Which ROS 2 distributions see this participant as a node: an endpoint's id has 24 bytes in their graph up to Humble,
/// 16 from Iron on, under one type name.
enum class RosGraph { kNone, kUpToHumble, kFromIron };

/// A node as ROS 2's graph names it.
struct NodeName {
  RosNamespace name_space;
  std::string name;  ///< without namespace, e.g. "slamfuse"
};

/// Makes a participant a node that `ros2 node list` and `ros2 node info` show: tells on `ros_discovery_info` which
/// readers and writers belong to it. Without it topics work all the same and have no node.
class GraphPresence {
 public:
  /// Error (kFailed): DDS makes no endpoint.
  static common::Result<GraphPresence> create(const Participant& participant, const NodeName& node, RosGraph graph);

  /// Tells of the endpoints the participant has now, if they are others than at the last time. Error (kFailed): not
  /// sent.
  common::Result<void> update();

 private:
  GraphPresence(Participant participant, NodeName node, RosGraph graph, Entity publications, Entity subscriptions,
                RawWriter writer);

  Participant participant_;
  NodeName node_;
  RosGraph graph_;
  Entity publications_;
  Entity subscriptions_;
  RawWriter writer_;
  std::vector<std::uint8_t> told_;
};

/// The message rmw_dds_common/msg/ParticipantEntitiesInfo with one node, as on the wire; ids of 16
/// bytes each.
std::vector<std::uint8_t> participant_entities_info(const std::string& participant, const NodeName& node,
                                                    const std::vector<std::string>& readers,
                                                    const std::vector<std::string>& writers, RosGraph graph);

}  // namespace slamfuse::idl
