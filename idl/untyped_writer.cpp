// SPDX-License-Identifier: BSD-3-Clause
#include "idl/untyped_writer.hpp"

#include <utility>

#include <dds/dds.h>

namespace slamfuse::idl {

common::Result<UntypedWriter> UntypedWriter::create(const Participant& participant, const dds_topic_descriptor& type,
                                                    const std::string& name, const dds_qos& qos) {
  auto topic_entity = own(dds_create_topic(participant.handle(), &type, name.c_str(), nullptr, nullptr),
                          "create topic " + name + " of type " + type.m_typename);
  if (!topic_entity) return tl::unexpected(topic_entity.error());
  auto writer =
      own(dds_create_writer(participant.handle(), topic_entity->handle(), &qos, nullptr), "create a writer of " + name);
  if (!writer) return tl::unexpected(writer.error());
  return UntypedWriter(participant, *std::move(topic_entity), *std::move(writer), name);
}

UntypedWriter::UntypedWriter(Participant participant, Entity topic, Entity writer, std::string name)
    : participant_(std::move(participant)),
      topic_(std::move(topic)),
      writer_(std::move(writer)),
      name_(std::move(name)) {}

common::Result<void> UntypedWriter::write(const void* sample) {
  const dds_return_t code = dds_write(writer_.handle(), sample);
  if (code != DDS_RETCODE_OK) return dds_failed("write to " + name_, code);
  return {};
}

std::uint64_t UntypedWriter::instance() const {
  dds_instance_handle_t instance = 0;
  dds_get_instance_handle(writer_.handle(), &instance);
  return instance;
}

int UntypedWriter::matched_readers() const {
  dds_publication_matched_status_t status{};
  if (dds_get_publication_matched_status(writer_.handle(), &status) != DDS_RETCODE_OK) return 0;
  return static_cast<int>(status.current_count);
}

bool UntypedWriter::wait_for_reader(std::chrono::nanoseconds timeout) const {
  if (matched_readers() > 0) return true;
  const Entity waitset(dds_create_waitset(participant_.handle()));
  dds_set_status_mask(writer_.handle(), DDS_PUBLICATION_MATCHED_STATUS);
  dds_waitset_attach(waitset.handle(), writer_.handle(), 0);
  dds_attach_t triggered = 0;
  dds_waitset_wait(waitset.handle(), &triggered, 1, timeout.count());
  return matched_readers() > 0;
}

bool UntypedWriter::wait_for_acknowledgments(std::chrono::nanoseconds timeout) const {
  return dds_wait_for_acks(writer_.handle(), timeout.count()) == DDS_RETCODE_OK;
}

}  // namespace slamfuse::idl
