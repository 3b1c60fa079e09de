// SPDX-License-Identifier: BSD-3-Clause
#include "idl/qos.hpp"

#include <cstddef>
#include <cstdint>

#include <dds/dds.h>

namespace slamfuse::idl {
namespace {

// What a reliable endpoint offers; with keep-last histories Cyclone's writes never wait.
constexpr dds_duration_t kMaxBlocking = DDS_MSECS(100);

struct Settings {
  dds_reliability_kind_t reliability;
  dds_durability_kind_t durability;
  std::int32_t depth;
};

Settings settings_of(QosProfile profile) {
  switch (profile) {
    case QosProfile::kSensorInput:
      return {DDS_RELIABILITY_BEST_EFFORT, DDS_DURABILITY_VOLATILE, 10};
    case QosProfile::kTransformInput:
      return {DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_VOLATILE, 100};
    case QosProfile::kStaticTransformInput:
      return {DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_TRANSIENT_LOCAL, 100};
    case QosProfile::kLatchedOutput:
      return {DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_TRANSIENT_LOCAL, 1};
    case QosProfile::kCommandInput:
    case QosProfile::kOutput:
      break;
  }
  return {DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_VOLATILE, 10};
}

}  // namespace

void DeleteQos::operator()(dds_qos* qos) const { dds_delete_qos(qos); }

UniqueQos make_qos(QosProfile profile) {
  const Settings settings = settings_of(profile);
  UniqueQos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), settings.reliability, kMaxBlocking);
  dds_qset_durability(qos.get(), settings.durability);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, settings.depth);
  if (settings.durability == DDS_DURABILITY_TRANSIENT_LOCAL) {
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, settings.depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  dds_qset_writer_data_lifecycle(qos.get(), false);
  const dds_data_representation_id_t representation = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &representation);
  return qos;
}

bool is_reliable(const dds_qos& qos) {
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  return dds_qget_reliability(&qos, &reliability, nullptr) && reliability == DDS_RELIABILITY_RELIABLE;
}

bool is_transient_local(const dds_qos& qos) {
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  return dds_qget_durability(&qos, &durability) && durability != DDS_DURABILITY_VOLATILE;
}

std::string user_data_of(const dds_qos& qos) {
  void* data = nullptr;
  std::size_t size = 0;
  if (!dds_qget_userdata(&qos, &data, &size) || data == nullptr) return {};
  std::string text(static_cast<const char*>(data), size);
  dds_free(data);
  return text;
}

}  // namespace slamfuse::idl
