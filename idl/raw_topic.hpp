// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/error.hpp"
#include "idl/entity.hpp"
#include "idl/participant.hpp"

struct ddsi_sertype;

namespace slamfuse::idl {

/// A topic of a raw type.
struct RawTopic {
  /// `name` and `type` as DDS names them.
  static common::Result<RawTopic> create(const Participant& participant, const std::string& name,
                                         const std::string& type);

  Entity entity;
  std::string name;                    ///< in DDS
  const ddsi_sertype* type = nullptr;  ///< lives as long as the entity
};

}  // namespace slamfuse::idl
