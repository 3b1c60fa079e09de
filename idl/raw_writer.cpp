// SPDX-License-Identifier: BSD-3-Clause
#include "idl/raw_writer.hpp"

#include <utility>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>

#include "idl/raw_topic.hpp"
#include "idl/raw_type.hpp"
#include "idl/ros_name.hpp"

namespace slamfuse::idl {

common::Result<RawWriter> RawWriter::create(const Participant& participant, const std::string& topic,
                                            const std::string& type, QosProfile profile) {
  return create_on(participant, dds_topic_name(topic), dds_type_name(type), profile);
}

common::Result<RawWriter> RawWriter::create_on(const Participant& participant, const std::string& topic,
                                               const std::string& type, QosProfile profile) {
  auto made = RawTopic::create(participant, topic, type);
  if (!made) return tl::unexpected(made.error());
  auto writer = own(dds_create_writer(participant.handle(), made->entity.handle(), make_qos(profile).get(), nullptr),
                    "create a writer of " + made->name);
  if (!writer) return tl::unexpected(writer.error());
  return RawWriter(participant, std::move(made->entity), *std::move(writer), *made->type, std::move(made->name));
}

RawWriter::RawWriter(Participant participant, Entity topic, Entity writer, const ddsi_sertype& type, std::string name)
    : participant_(std::move(participant)),
      topic_(std::move(topic)),
      writer_(std::move(writer)),
      type_(&type),
      name_(std::move(name)) {}

common::Result<void> RawWriter::write(std::span<const std::uint8_t> bytes) {
  ddsi_serdata* const message = make_raw_message(*type_, bytes);
  if (message == nullptr) return common::failed("write to " + name_ + ": no serialised message");
  const dds_return_t code = dds_writecdr(writer_.handle(), message);  // takes the message over
  if (code != DDS_RETCODE_OK) return dds_failed("write to " + name_, code);
  return {};
}

int RawWriter::matched_readers() const {
  dds_publication_matched_status_t status{};
  if (dds_get_publication_matched_status(writer_.handle(), &status) != DDS_RETCODE_OK) return 0;
  return static_cast<int>(status.current_count);
}

bool RawWriter::wait_for_acknowledgments(std::chrono::nanoseconds timeout) const {
  return dds_wait_for_acks(writer_.handle(), timeout.count()) == DDS_RETCODE_OK;
}

}  // namespace slamfuse::idl
