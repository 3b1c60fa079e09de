// SPDX-License-Identifier: BSD-3-Clause
#include "idl/entity.hpp"

#include <utility>

#include <dds/dds.h>

#include "idl/cyclone_log.hpp"

namespace slamfuse::idl {

Entity::~Entity() {
  if (handle_ > 0) dds_delete(handle_);
}

Entity::Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}

Entity& Entity::operator=(Entity&& other) noexcept {
  std::swap(handle_, other.handle_);
  return *this;
}

common::Result<Entity> own(Entity::Handle handle_or_error, const std::string& what) {
  if (handle_or_error < 0) return dds_failed(what, handle_or_error);
  return Entity(handle_or_error);
}

tl::unexpected<common::Error> dds_failed(const std::string& what, std::int32_t code) {
  const std::string log = take_cyclone_log();
  return common::failed("DDS: cannot " + what + ": " + dds_strretcode(code) + (log.empty() ? "" : " (" + log + ")"));
}

}  // namespace slamfuse::idl
