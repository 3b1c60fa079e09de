// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "idl/message.hpp"
#include "idl/ros_name.hpp"
#include "idl/untyped_reader.hpp"

namespace slamfuse::idl {

/// Receives messages of one type from one ROS 2 topic, through a waitset; no callbacks in Cyclone's threads (a slow one
/// makes other readers lose data). For one thread at a time.
template <class T>
class Reader {
 public:
  /// `topic` is the ROS name without a leading slash, e.g. "scan".
  static common::Result<Reader> create(const Participant& participant, const std::string& topic, QosProfile profile) {
    return UntypedReader::create(participant, descriptor<T>(), dds_topic_name(topic), *make_qos(profile))
        .map([](UntypedReader&& reader) { return Reader(std::move(reader)); });
  }

  /// The next message, waiting at most `timeout` for it; nothing when none came. The fields are as the sender wrote
  /// them: check that numbers are finite and in range before use.
  common::Result<std::optional<Message<T>>> take(std::chrono::nanoseconds timeout = {}) {
    Message<T> message;
    return reader_.take(&*message, timeout).map([&](bool taken) {
      return taken ? std::optional<Message<T>>(std::move(message)) : std::nullopt;
    });
  }

  /// Which writer the last taken message came from; see UntypedReader::sender().
  std::uint64_t sender() { return reader_.sender(); }
  int matched_writers() const { return reader_.matched_writers(); }
  /// For a WaitSet.
  const UntypedReader& untyped() const { return reader_; }
  /// May be asked from another thread.
  ReaderHealth health() const { return reader_.health(); }

 private:
  explicit Reader(UntypedReader reader) : reader_(std::move(reader)) {}
  UntypedReader reader_;
};

}  // namespace slamfuse::idl
