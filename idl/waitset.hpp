// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

#include "common/error.hpp"
#include "idl/entity.hpp"
#include "idl/participant.hpp"
#include "idl/untyped_reader.hpp"

namespace slamfuse::idl {

/// Waits until one of several readers has a message, so that one thread can serve them all.
class WaitSet {
 public:
  static common::Result<WaitSet> create(const Participant& participant);

  /// `reader` must outlive the waits. Error (kFailed): DDS refuses.
  common::Result<void> add(const UntypedReader& reader);
  /// Waits at most `timeout`; false when there was nothing.
  bool wait(std::chrono::nanoseconds timeout) const;

 private:
  WaitSet(Participant participant, Entity waitset)
      : participant_(std::move(participant)), waitset_(std::move(waitset)) {}
  Participant participant_;
  Entity waitset_;
};

}  // namespace slamfuse::idl
