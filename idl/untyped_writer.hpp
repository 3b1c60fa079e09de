// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "common/error.hpp"
#include "idl/participant.hpp"
#include "idl/qos.hpp"

struct dds_topic_descriptor;

namespace slamfuse::idl {

/// What Writer<T> does without knowing T.
class UntypedWriter {
 public:
  /// `topic` is the DDS name, e.g. "rt/scan".
  static common::Result<UntypedWriter> create(const Participant& participant, const dds_topic_descriptor& type,
                                              const std::string& topic, const dds_qos& qos);
  common::Result<void> write(const void* sample);
  int matched_readers() const;
  /// What Cyclone calls this writer; other than 0.
  std::uint64_t instance() const;
  bool wait_for_reader(std::chrono::nanoseconds timeout) const;
  bool wait_for_acknowledgments(std::chrono::nanoseconds timeout) const;

 private:
  UntypedWriter(Participant participant, Entity topic, Entity writer, std::string name);
  Participant participant_;
  Entity topic_;
  Entity writer_;
  std::string name_;
};

}  // namespace slamfuse::idl
