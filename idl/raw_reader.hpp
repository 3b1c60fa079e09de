// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "idl/entity.hpp"
#include "idl/participant.hpp"

namespace slamfuse::idl {

/// Receives the messages of a ROS 2 topic of any type as they are on the wire: the encapsulation header and the CDR, as
/// a rosbag2 stores them. Keeps everything until it is taken. For one thread at a time.
class RawReader {
 public:
  /// What it asks of writers: more than one offers, and they do not meet.
  struct Demands {
    bool reliable = false;
    bool transient_local = false;
  };

  /// `topic` and `type` as ROS names them.
  static common::Result<RawReader> create(const Participant& participant, const std::string& topic,
                                          const std::string& type, const Demands& demands);
  /// The same with names as in DDS.
  static common::Result<RawReader> create_on(const Participant& participant, const std::string& topic,
                                             const std::string& type, const Demands& demands);

  /// The next message, waiting at most `timeout` for it; nothing when none came.
  common::Result<std::optional<std::vector<std::uint8_t>>> take(std::chrono::nanoseconds timeout);
  /// Messages that never arrived, as far as the transport knows.
  std::size_t lost() const;
  /// Whether a writer offers less than was demanded, so that its messages do not come.
  bool refused_a_writer() const;

 private:
  RawReader(Participant participant, Entity topic, Entity reader, Entity condition, Entity waitset, std::string name);
  common::Result<std::optional<std::vector<std::uint8_t>>> take_available();

  Participant participant_;
  Entity topic_;
  Entity reader_;
  Entity condition_;
  Entity waitset_;
  std::string name_;
};

}  // namespace slamfuse::idl
