// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <string>
#include <utility>

#include "idl/message.hpp"
#include "idl/ros_name.hpp"
#include "idl/untyped_writer.hpp"

namespace slamfuse::idl {

/// Publishes messages of one type on one ROS 2 topic. For one thread at a time.
template <class T>
class Writer {
 public:
  /// `topic` is the ROS name without a leading slash, e.g. "slamfuse/pose".
  static common::Result<Writer> create(const Participant& participant, const std::string& topic, QosProfile profile) {
    return UntypedWriter::create(participant, descriptor<T>(), dds_topic_name(topic), *make_qos(profile))
        .map([](UntypedWriter&& writer) { return Writer(std::move(writer)); });
  }

  /// Sends a copy. Never waits for a reader: one that does not keep up misses messages. Error (kFailed): the domain
  /// broke.
  common::Result<void> write(const Message<T>& message) { return writer_.write(&*message); }

  int matched_readers() const { return writer_.matched_readers(); }
  /// Waits until a reader is known, at most `timeout`. False when there is none.
  bool wait_for_reader(std::chrono::nanoseconds timeout) const { return writer_.wait_for_reader(timeout); }
  /// Waits until every known reliable reader has everything, at most `timeout`. True when they have.
  bool wait_for_acknowledgments(std::chrono::nanoseconds timeout) const {
    return writer_.wait_for_acknowledgments(timeout);
  }

 private:
  explicit Writer(UntypedWriter writer) : writer_(std::move(writer)) {}
  UntypedWriter writer_;
};

}  // namespace slamfuse::idl
