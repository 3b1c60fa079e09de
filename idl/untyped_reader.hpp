// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "common/error.hpp"
#include "idl/participant.hpp"
#include "idl/qos.hpp"

struct dds_topic_descriptor;

namespace slamfuse::idl {

/// How a reader fares with the writers of its topic.
struct ReaderHealth {
  int matched_writers = 0;
  std::string
      incompatible_qos;  ///< what a writer offers that is not enough, e.g. "reliability"; empty: all offer enough
  std::size_t lost = 0;  ///< messages that never arrived, as far as the transport knows
};

/// What Reader<T> does without knowing T.
class UntypedReader {
 public:
  /// `topic` is the DDS name, e.g. "rt/scan".
  static common::Result<UntypedReader> create(const Participant& participant, const dds_topic_descriptor& type,
                                              const std::string& topic, const dds_qos& qos);
  /// Fills `sample` (zeroed memory of the type) with the next message; false when there is none within `timeout`.
  common::Result<bool> take(void* sample, std::chrono::nanoseconds timeout);
  /// USER_DATA of the writer the last taken message came from; empty when it has none, or has gone.
  std::string sender_user_data() const;
  /// A number of that writer: another one for another writer, as after its process was started again, the same one when
  /// only its network was away. 0 before the first message.
  std::uint64_t sender();
  int matched_writers() const;
  /// What a WaitSet waits for.
  Entity::Handle condition() const { return condition_.handle(); }
  ReaderHealth health() const;

 private:
  UntypedReader(Participant participant, Entity topic, Entity reader, Entity condition, Entity waitset,
                std::string name);
  common::Result<bool> take_available(void* sample);
  Participant participant_;
  Entity topic_;
  Entity reader_;
  Entity condition_;
  Entity waitset_;
  std::string name_;
  std::uint64_t last_sender_ = 0;   // instance handle of a writer
  std::uint64_t known_sender_ = 0;  // the one that sender_number_ is of
  std::uint64_t sender_number_ = 0;
};

}  // namespace slamfuse::idl
