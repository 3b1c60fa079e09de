// SPDX-License-Identifier: BSD-3-Clause
#include "idl/output_health.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <utility>

#include <dds/dds.h>

#include "idl/message.hpp"
#include "idl/qos.hpp"
#include "idl/ros_name.hpp"

namespace slamfuse::idl {
namespace {

/// What is looked at of each kind.
constexpr std::size_t kMost = 1024;

/// What Cyclone's participants tell of their process, for people to read.
constexpr const char* kProcessName = "__ProcessName";
constexpr const char* kProcessId = "__Pid";
constexpr const char* kHost = "__Hostname";

struct Subscription {
  dds_instance_handle_t handle = 0;
  std::string topic;
  std::string type;  // as DDS names it
  std::string id;
  std::string participant;
  bool reliable = false;
  bool transient_local = false;
  bool takes_xcdr1 = true;
};

template <std::size_t kSize>
std::string bytes_of(const unsigned char (&id)[kSize]) {
  return {reinterpret_cast<const char*>(id), kSize};
}

std::string in_hex(const std::string& bytes) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (const char byte : bytes) {
    text += kDigits[static_cast<unsigned char>(byte) >> 4];
    text += kDigits[static_cast<unsigned char>(byte) & 15];
  }
  return text;
}

/// Calls `use(sample, info)` for everything alive on one of Cyclone's builtin topics.
template <class Sample, class Use>
void for_each(const Entity& builtin, const Use& use) {
  std::array<void*, kMost> samples{};
  std::array<dds_sample_info_t, kMost> infos{};
  const dds_return_t count = dds_read_mask(builtin.handle(), samples.data(), infos.data(), kMost, kMost,
                                           DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE);
  for (dds_return_t i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (infos[at].valid_data) use(*static_cast<const Sample*>(samples[at]), infos[at]);
  }
  if (count > 0) dds_return_loan(builtin.handle(), samples.data(), count);
}

bool takes_xcdr1(const dds_qos_t& qos) {
  std::uint32_t count = 0;
  dds_data_representation_id_t* values = nullptr;
  if (!dds_qget_data_representation(&qos, &count, &values) || count == 0) return true;
  const bool takes = std::find(values, values + count, DDS_DATA_REPRESENTATION_XCDR1) != values + count;
  dds_free(values);
  return takes;
}

Subscription to_subscription(const dds_builtintopic_endpoint_t& reader, dds_instance_handle_t handle) {
  Subscription subscription;
  subscription.handle = handle;
  subscription.topic = reader.topic_name;
  subscription.type = reader.type_name;
  subscription.id = bytes_of(reader.key.v);
  subscription.participant = bytes_of(reader.participant_key.v);
  subscription.reliable = is_reliable(*reader.qos);
  subscription.transient_local = is_transient_local(*reader.qos);
  subscription.takes_xcdr1 = takes_xcdr1(*reader.qos);
  return subscription;
}

std::string property(const dds_qos_t& qos, const char* name) {
  char* value = nullptr;
  if (!dds_qget_prop(&qos, name, &value) || value == nullptr) return {};
  std::string text = value;
  dds_free(value);
  return text;
}

/// Names of participants by their ids; those that tell none are left out.
std::map<std::string, std::string> names_of(const Entity& participants) {
  std::map<std::string, std::string> names;
  for_each<dds_builtintopic_participant_t>(participants, [&](const auto& participant, const auto&) {
    const std::string process = property(*participant.qos, kProcessName);
    if (process.empty()) return;
    names[bytes_of(participant.key.v)] = process + " (process " + property(*participant.qos, kProcessId) + " on " +
                                         property(*participant.qos, kHost) + ")";
  });
  return names;
}

std::vector<Entity::Handle> children_of(Entity::Handle entity) {
  std::array<dds_entity_t, kMost> children{};
  const dds_return_t count = dds_get_children(entity, children.data(), children.size());
  if (count <= 0) return {};
  const auto kept = std::min(static_cast<std::size_t>(count), children.size());
  return {children.begin(), children.begin() + static_cast<std::ptrdiff_t>(kept)};
}

std::string name_of(Entity::Handle topic, dds_return_t (*get)(dds_entity_t, char*, std::size_t)) {
  std::array<char, 256> name{};
  return get(topic, name.data(), name.size()) < 0 ? std::string() : std::string(name.data());
}

/// What a reader of the same topic asks for that the writer does not offer.
std::string reason(const Subscription& reader, const std::string& type, const dds_qos_t& offered) {
  if (reader.type != type) return ros_type_name(reader.type) + " expected, " + ros_type_name(type) + " published";
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  dds_qget_durability(&offered, &durability);
  if (reader.transient_local && durability == DDS_DURABILITY_VOLATILE) {
    return "transient local requested, volatile offered";
  }
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_qget_reliability(&offered, &reliability, nullptr);
  if (reader.reliable && reliability == DDS_RELIABILITY_BEST_EFFORT) return "reliable requested, best effort offered";
  if (!reader.takes_xcdr1) return "data representation XCDR2 requested, XCDR1 offered";
  return "a policy it requests is not offered";
}

}  // namespace

common::Result<Outputs> Outputs::create(const Participant& participant) {
  auto subscriptions =
      own(dds_create_reader(participant.handle(), DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr),
          "list the readers");
  if (!subscriptions) return tl::unexpected(subscriptions.error());
  auto participants = own(dds_create_reader(participant.handle(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr),
                          "list the participants");
  if (!participants) return tl::unexpected(participants.error());
  return Outputs(participant, *std::move(subscriptions), *std::move(participants));
}

std::vector<OutputHealth> Outputs::look() const {
  dds_guid_t own_id{};
  dds_get_guid(participant_.handle(), &own_id);
  const std::string ours = bytes_of(own_id.v);
  std::vector<Subscription> readers;
  for_each<dds_builtintopic_endpoint_t>(subscriptions_, [&](const auto& reader, const auto& info) {
    if (is_ros_topic(reader.topic_name) && bytes_of(reader.participant_key.v) != ours) {
      readers.push_back(to_subscription(reader, info.instance_handle));
    }
  });
  const auto names = names_of(participants_);

  std::vector<OutputHealth> outputs;
  for (const Entity::Handle child : children_of(participant_.handle())) {
    for (const Entity::Handle writer : children_of(child)) {
      std::array<dds_instance_handle_t, kMost> matched{};
      const dds_return_t count = dds_get_matched_subscriptions(writer, matched.data(), matched.size());
      const Entity::Handle topic = dds_get_topic(writer);
      if (count < 0 || topic < 0) continue;  // no writer, or ended meanwhile
      const std::string name = name_of(topic, dds_get_name);
      const std::string type = name_of(topic, dds_get_type_name);
      const UniqueQos offered(dds_create_qos());
      if (!is_ros_topic(name) || dds_get_qos(writer, offered.get()) != DDS_RETCODE_OK) continue;
      const auto end = matched.begin() + static_cast<std::ptrdiff_t>(std::min(static_cast<std::size_t>(count), kMost));
      OutputHealth output{ros_topic_name(name), ros_type_name(type), 0, {}};
      for (const Subscription& reader : readers) {
        if (reader.topic != name) continue;
        if (std::find(matched.begin(), end, reader.handle) != end) {
          ++output.readers;
          continue;
        }
        const auto who = names.find(reader.participant);
        output.refused.push_back(
            {who != names.end() ? who->second : in_hex(reader.id), reason(reader, type, *offered)});
      }
      outputs.push_back(std::move(output));
    }
  }
  std::ranges::sort(outputs, {}, &OutputHealth::topic);
  return outputs;
}

}  // namespace slamfuse::idl
