// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/error.hpp"
#include "idl/entity.hpp"
#include "idl/participant.hpp"

namespace slamfuse::idl {

/// A reader of a topic that gets nothing from our writer of it.
struct RefusedReader {
  std::string who;  ///< "rviz2 (process 812 on robot)"; where its participant tells no name, its id in hexadecimal
  std::string why;  ///< "transient local requested, volatile offered"
};

/// Who listens to a writer of ours.
struct OutputHealth {
  std::string topic;  ///< ROS name without a leading slash
  std::string type;   ///< ROS name, e.g. "nav_msgs/msg/Path"
  int readers = 0;    ///< matched, those of our own participant not counted
  std::vector<RefusedReader> refused;
};

/// All writers of ROS 2 topics that a participant has, as Cyclone knows them.
class Outputs {
 public:
  /// Error (kFailed): DDS makes no reader of its discovery.
  static common::Result<Outputs> create(const Participant& participant);

  /// By rising topic. From one thread at a time, while others make and end writers.
  std::vector<OutputHealth> look() const;

 private:
  Outputs(Participant participant, Entity subscriptions, Entity participants)
      : participant_(std::move(participant)),
        subscriptions_(std::move(subscriptions)),
        participants_(std::move(participants)) {}
  Participant participant_;
  Entity subscriptions_;
  Entity participants_;
};

}  // namespace slamfuse::idl
