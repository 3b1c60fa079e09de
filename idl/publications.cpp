// SPDX-License-Identifier: BSD-3-Clause
#include "idl/publications.hpp"

#include <array>
#include <cstring>

#include <dds/dds.h>

#include "idl/message.hpp"
#include "idl/qos.hpp"
#include "idl/ros_name.hpp"

namespace slamfuse::idl {
namespace {

constexpr std::size_t kMostWriters = 1024;

Publication to_publication(const dds_builtintopic_endpoint_t& writer, const dds_guid_t& looking) {
  Publication publication;
  publication.topic = ros_topic_name(writer.topic_name);
  publication.type = ros_type_name(writer.type_name);
  publication.gid.assign(reinterpret_cast<const char*>(writer.key.v), sizeof(writer.key.v));
  publication.ours = std::memcmp(writer.participant_key.v, looking.v, sizeof(looking.v)) == 0;
  publication.reliable = is_reliable(*writer.qos);
  publication.transient_local = is_transient_local(*writer.qos);
  return publication;
}

}  // namespace

common::Result<Publications> Publications::create(const Participant& participant) {
  return own(dds_create_reader(participant.handle(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
             "listen for publishers")
      .map([&](Entity&& reader) { return Publications(participant, std::move(reader)); });
}

std::vector<Publication> Publications::look() const {
  std::vector<Publication> publications;
  dds_guid_t looking{};
  dds_get_guid(participant_.handle(), &looking);
  std::array<void*, kMostWriters> samples{};
  std::array<dds_sample_info_t, kMostWriters> infos{};
  const dds_return_t count = dds_read_mask(reader_.handle(), samples.data(), infos.data(), kMostWriters, kMostWriters,
                                           DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE);
  for (dds_return_t i = 0; i < count; ++i) {
    const auto& writer = *static_cast<const dds_builtintopic_endpoint_t*>(samples[static_cast<std::size_t>(i)]);
    if (!infos[static_cast<std::size_t>(i)].valid_data || !is_ros_topic(writer.topic_name)) continue;
    publications.push_back(to_publication(writer, looking));
  }
  if (count > 0) dds_return_loan(reader_.handle(), samples.data(), count);
  return publications;
}

}  // namespace slamfuse::idl
