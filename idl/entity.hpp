// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "common/error.hpp"

namespace slamfuse::idl {

/// Owns one Cyclone DDS entity (domain, participant, topic, reader, ...) and deletes it at the end.
class Entity {
 public:
  using Handle = std::int32_t;  ///< dds_entity_t

  Entity() = default;
  explicit Entity(Handle handle) : handle_(handle) {}
  ~Entity();
  Entity(Entity&& other) noexcept;
  Entity& operator=(Entity&& other) noexcept;

  Handle handle() const { return handle_; }

 private:
  Handle handle_ = 0;
};

/// Takes over what a dds_create_... function returned, or tells what could not be done and why.
common::Result<Entity> own(Entity::Handle handle_or_error, const std::string& what);

/// An error value with Cyclone's words for a (negative) return code and what it has logged last.
tl::unexpected<common::Error> dds_failed(const std::string& what, std::int32_t code);

}  // namespace slamfuse::idl
