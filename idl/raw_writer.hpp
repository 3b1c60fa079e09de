// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>

#include "common/error.hpp"
#include "idl/entity.hpp"
#include "idl/participant.hpp"
#include "idl/qos.hpp"

struct ddsi_sertype;

namespace slamfuse::idl {

/// Publishes messages of any type that are serialised already, see RawReader. For one thread at a time.
class RawWriter {
 public:
  static common::Result<RawWriter> create(const Participant& participant, const std::string& topic,
                                          const std::string& type, QosProfile profile);
  /// The same with names as in DDS.
  static common::Result<RawWriter> create_on(const Participant& participant, const std::string& topic,
                                             const std::string& type, QosProfile profile);

  /// Error (kFailed): a reliable reader did not keep up, or the bytes are no serialised message.
  common::Result<void> write(std::span<const std::uint8_t> bytes);
  int matched_readers() const;
  /// Waits until every known reliable reader has everything, at most `timeout`.
  bool wait_for_acknowledgments(std::chrono::nanoseconds timeout) const;

 private:
  RawWriter(Participant participant, Entity topic, Entity writer, const ddsi_sertype& type, std::string name);
  Participant participant_;
  Entity topic_;
  Entity writer_;
  const ddsi_sertype* type_;
  std::string name_;
};

}  // namespace slamfuse::idl
