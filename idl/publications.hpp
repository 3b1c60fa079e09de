// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/error.hpp"
#include "idl/entity.hpp"
#include "idl/participant.hpp"

namespace slamfuse::idl {

/// A writer of a ROS 2 topic somewhere in the domain.
struct Publication {
  std::string topic;  ///< ROS name without a leading slash
  std::string type;   ///< ROS name, e.g. "sensor_msgs/msg/LaserScan"
  bool reliable = false;
  bool transient_local = false;
  std::string gid;    ///< what tells it from others, 16 bytes
  bool ours = false;  ///< of the participant that looks
};

/// Who publishes what in a domain, as DDS discovery knows.
class Publications {
 public:
  static common::Result<Publications> create(const Participant& participant);

  /// All writers of ROS 2 topics known now, in no order. Services are left out.
  std::vector<Publication> look() const;

 private:
  Publications(Participant participant, Entity reader)
      : participant_(std::move(participant)), reader_(std::move(reader)) {}
  Participant participant_;
  Entity reader_;
};

}  // namespace slamfuse::idl
