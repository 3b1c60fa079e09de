// SPDX-License-Identifier: BSD-3-Clause
#include "idl/raw_reader.hpp"

#include <utility>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>

#include "idl/qos.hpp"
#include "idl/raw_topic.hpp"
#include "idl/raw_type.hpp"
#include "idl/ros_name.hpp"

namespace slamfuse::idl {

common::Result<RawReader> RawReader::create(const Participant& participant, const std::string& topic,
                                            const std::string& type, const Demands& demands) {
  return create_on(participant, dds_topic_name(topic), dds_type_name(type), demands);
}

common::Result<RawReader> RawReader::create_on(const Participant& participant, const std::string& topic,
                                               const std::string& type, const Demands& demands) {
  auto made = RawTopic::create(participant, topic, type);
  if (!made) return tl::unexpected(made.error());
  const UniqueQos qos = make_qos(QosProfile::kSensorInput);
  dds_qset_reliability(qos.get(), demands.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_durability(qos.get(), demands.transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, DDS_LENGTH_UNLIMITED);
  auto reader = own(dds_create_reader(participant.handle(), made->entity.handle(), qos.get(), nullptr),
                    "create a reader of " + made->name);
  if (!reader) return tl::unexpected(reader.error());
  auto condition = own(dds_create_readcondition(reader->handle(), DDS_ANY_STATE), "watch for messages on " + topic);
  if (!condition) return tl::unexpected(condition.error());
  auto waitset = own(dds_create_waitset(participant.handle()), "wait for messages on " + topic);
  if (!waitset) return tl::unexpected(waitset.error());
  const dds_return_t code = dds_waitset_attach(waitset->handle(), condition->handle(), 0);
  if (code != DDS_RETCODE_OK) return dds_failed("wait for messages on " + topic, code);
  return RawReader(participant, std::move(made->entity), *std::move(reader), *std::move(condition), *std::move(waitset),
                   std::move(made->name));
}

RawReader::RawReader(Participant participant, Entity topic, Entity reader, Entity condition, Entity waitset,
                     std::string name)
    : participant_(std::move(participant)),
      topic_(std::move(topic)),
      reader_(std::move(reader)),
      condition_(std::move(condition)),
      waitset_(std::move(waitset)),
      name_(std::move(name)) {}

common::Result<std::optional<std::vector<std::uint8_t>>> RawReader::take(std::chrono::nanoseconds timeout) {
  const dds_time_t deadline = dds_time() + timeout.count();
  while (true) {
    auto taken = take_available();
    if (!taken || *taken || dds_time() >= deadline) return taken;
    const dds_return_t code = dds_waitset_wait_until(waitset_.handle(), nullptr, 0, deadline);
    if (code < 0) return dds_failed("wait for messages on " + name_, code);
  }
}

common::Result<std::optional<std::vector<std::uint8_t>>> RawReader::take_available() {
  while (true) {
    ddsi_serdata* message = nullptr;
    dds_sample_info_t info{};
    const dds_return_t count = dds_takecdr(reader_.handle(), &message, 1, &info, DDS_ANY_STATE);
    if (count < 0) return dds_failed("take a message from " + name_, count);
    if (count == 0) return std::optional<std::vector<std::uint8_t>>();
    std::optional<std::vector<std::uint8_t>> bytes;
    if (info.valid_data) bytes = bytes_of(*message);  // otherwise only news of a writer that ended
    ddsi_serdata_unref(message);
    if (bytes) return bytes;
  }
}

std::size_t RawReader::lost() const {
  dds_sample_lost_status_t status{};
  if (dds_get_sample_lost_status(reader_.handle(), &status) != DDS_RETCODE_OK) return 0;
  return status.total_count;
}

bool RawReader::refused_a_writer() const {
  dds_requested_incompatible_qos_status_t status{};
  return dds_get_requested_incompatible_qos_status(reader_.handle(), &status) == DDS_RETCODE_OK &&
         status.total_count > 0;
}

}  // namespace slamfuse::idl
