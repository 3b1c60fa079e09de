// SPDX-License-Identifier: BSD-3-Clause
#include "idl/raw_topic.hpp"

#include <utility>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_sertype.h>

#include "idl/raw_type.hpp"

namespace slamfuse::idl {

common::Result<RawTopic> RawTopic::create(const Participant& participant, const std::string& name,
                                          const std::string& type) {
  ddsi_sertype* raw_type = make_raw_type(type);
  const Entity::Handle handle =
      dds_create_topic_sertype(participant.handle(), name.c_str(), &raw_type, nullptr, nullptr, nullptr);
  if (handle < 0) ddsi_sertype_unref(raw_type);
  return own(handle, "create topic " + name + " of type " + type).map([&](Entity&& entity) {
    return RawTopic{std::move(entity), name, raw_type};
  });
}

}  // namespace slamfuse::idl
