// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "common/error.hpp"
#include "idl/domain_settings.hpp"
#include "idl/entity.hpp"

namespace slamfuse::idl {

/// Membership in a DDS domain, recognisable to ROS 2 (USER_DATA "enclave=/;", or the enclave's name). A handle: copies
/// share the membership, which ends with the last copy, reader or writer.
class Participant {
 public:
  /// Joins. With `loopback_only` the interface `lo` is forced on top of what CYCLONEDDS_URI sets; participants of one
  /// process in one domain must agree on it, else kFailed.
  static common::Result<Participant> create(const DomainSettings& settings);
  /// Joins the domain that the environment names, see domain_from_environment(). Errors of both.
  static common::Result<Participant> join(Network network);

  Entity::Handle handle() const;

 private:
  struct State;
  explicit Participant(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  std::shared_ptr<const State> state_;
};

}  // namespace slamfuse::idl
