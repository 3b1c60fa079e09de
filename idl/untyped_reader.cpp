// SPDX-License-Identifier: BSD-3-Clause
#include "idl/untyped_reader.hpp"

#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>

#include <dds/dds.h>

namespace slamfuse::idl {
namespace {

// The policies ROS 2 users set, in their words.
std::string policy_name(std::uint32_t policy) {
  switch (policy) {
    case DDS_RELIABILITY_QOS_POLICY_ID:
      return "reliability";
    case DDS_DURABILITY_QOS_POLICY_ID:
      return "durability";
    case DDS_DATA_REPRESENTATION_QOS_POLICY_ID:
      return "data representation";
    default:
      return "policy " + std::to_string(policy);
  }
}

}  // namespace

common::Result<UntypedReader> UntypedReader::create(const Participant& participant, const dds_topic_descriptor& type,
                                                    const std::string& name, const dds_qos& qos) {
  auto topic_entity = own(dds_create_topic(participant.handle(), &type, name.c_str(), nullptr, nullptr),
                          "create topic " + name + " of type " + type.m_typename);
  if (!topic_entity) return tl::unexpected(topic_entity.error());
  auto reader =
      own(dds_create_reader(participant.handle(), topic_entity->handle(), &qos, nullptr), "create a reader of " + name);
  if (!reader) return tl::unexpected(reader.error());
  auto condition = own(dds_create_readcondition(reader->handle(), DDS_ANY_STATE), "watch for messages on " + name);
  if (!condition) return tl::unexpected(condition.error());
  auto waitset = own(dds_create_waitset(participant.handle()), "wait for messages on " + name);
  if (!waitset) return tl::unexpected(waitset.error());
  const dds_return_t code = dds_waitset_attach(waitset->handle(), condition->handle(), 0);
  if (code != DDS_RETCODE_OK) return dds_failed("wait for messages on " + name, code);
  return UntypedReader(participant, *std::move(topic_entity), *std::move(reader), *std::move(condition),
                       *std::move(waitset), name);
}

UntypedReader::UntypedReader(Participant participant, Entity topic, Entity reader, Entity condition, Entity waitset,
                             std::string name)
    : participant_(std::move(participant)),
      topic_(std::move(topic)),
      reader_(std::move(reader)),
      condition_(std::move(condition)),
      waitset_(std::move(waitset)),
      name_(std::move(name)) {}

common::Result<bool> UntypedReader::take(void* sample, std::chrono::nanoseconds timeout) {
  const dds_time_t deadline = dds_time() + timeout.count();
  while (true) {
    auto taken = take_available(sample);
    if (!taken || *taken) return taken;
    if (dds_time() >= deadline) return false;
    dds_attach_t triggered = 0;
    const dds_return_t code = dds_waitset_wait_until(waitset_.handle(), &triggered, 1, deadline);
    if (code < 0) return dds_failed("wait for messages on " + name_, code);
  }
}

common::Result<bool> UntypedReader::take_available(void* sample) {
  while (true) {
    dds_sample_info_t info{};
    const dds_return_t count = dds_take(reader_.handle(), &sample, &info, 1, 1);
    if (count < 0) return dds_failed("take a message from " + name_, count);
    if (count == 0) return false;
    last_sender_ = info.publication_handle;
    if (info.valid_data) return true;  // otherwise only news of a writer that ended
  }
}

std::string UntypedReader::sender_user_data() const {
  dds_builtintopic_endpoint_t* const writer = dds_get_matched_publication_data(reader_.handle(), last_sender_);
  if (writer == nullptr) return {};
  std::string text = user_data_of(*writer->qos);
  dds_builtintopic_free_endpoint(writer);
  return text;
}

// A handle is new whenever a writer is discovered, also after its network was away; its GUID stays.
std::uint64_t UntypedReader::sender() {
  if (last_sender_ == known_sender_) return sender_number_;
  dds_builtintopic_endpoint_t* const writer = dds_get_matched_publication_data(reader_.handle(), last_sender_);
  if (writer == nullptr) return sender_number_;  // already gone
  const std::string_view guid(reinterpret_cast<const char*>(writer->key.v), sizeof(writer->key.v));
  sender_number_ = std::hash<std::string_view>()(guid);
  known_sender_ = last_sender_;
  dds_builtintopic_free_endpoint(writer);
  return sender_number_;
}

int UntypedReader::matched_writers() const {
  dds_subscription_matched_status_t status{};
  if (dds_get_subscription_matched_status(reader_.handle(), &status) != DDS_RETCODE_OK) return 0;
  return static_cast<int>(status.current_count);
}

ReaderHealth UntypedReader::health() const {
  ReaderHealth health{matched_writers(), {}, 0};
  dds_requested_incompatible_qos_status_t incompatible{};
  if (dds_get_requested_incompatible_qos_status(reader_.handle(), &incompatible) == DDS_RETCODE_OK &&
      incompatible.total_count > 0) {
    health.incompatible_qos = policy_name(incompatible.last_policy_id);
  }
  dds_sample_lost_status_t lost{};
  if (dds_get_sample_lost_status(reader_.handle(), &lost) == DDS_RETCODE_OK) health.lost = lost.total_count;
  return health;
}

}  // namespace slamfuse::idl
