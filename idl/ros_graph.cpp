// SPDX-License-Identifier: BSD-3-Clause
#include "idl/ros_graph.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include <dds/dds.h>

namespace slamfuse::idl {
namespace {

constexpr std::size_t kGuidBytes = 16;
constexpr std::size_t kHumbleGidBytes = 24;
constexpr std::size_t kMostEndpoints = 1024;

std::string guid_of(Entity::Handle entity) {
  dds_guid_t guid{};
  dds_get_guid(entity, &guid);
  return {reinterpret_cast<const char*>(guid.v), sizeof(guid.v)};
}

/// Ids of the endpoints on a builtin topic that belong to a participant, sorted.
std::vector<std::string> endpoints_of(const std::string& participant, const Entity& builtin) {
  std::array<void*, kMostEndpoints> samples{};
  std::array<dds_sample_info_t, kMostEndpoints> infos{};
  const dds_return_t count =
      dds_read_mask(builtin.handle(), samples.data(), infos.data(), kMostEndpoints, kMostEndpoints,
                    DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE);
  std::vector<std::string> ids;
  for (dds_return_t i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (!infos[at].valid_data) continue;
    const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(samples[at]);
    if (std::memcmp(endpoint.participant_key.v, participant.data(), kGuidBytes) != 0) continue;
    ids.emplace_back(reinterpret_cast<const char*>(endpoint.key.v), kGuidBytes);
  }
  if (count > 0) dds_return_loan(builtin.handle(), samples.data(), count);
  std::ranges::sort(ids);
  return ids;
}

/// Little-endian CDR, aligned from behind the encapsulation header.
class CdrWriter {
 public:
  void number(std::uint32_t value) {
    while ((bytes_.size() - kHeader) % sizeof(value) != 0) bytes_.push_back(0);
    for (std::size_t i = 0; i < sizeof(value); ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  void text(const std::string& text) {
    number(static_cast<std::uint32_t>(text.size()) + 1);
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
  }
  void octets(const std::string& octets, std::size_t length) {
    bytes_.insert(bytes_.end(), octets.begin(), octets.end());
    bytes_.insert(bytes_.end(), length - octets.size(), 0);
  }
  std::vector<std::uint8_t> bytes() && { return std::move(bytes_); }

 private:
  static constexpr std::size_t kHeader = 4;
  std::vector<std::uint8_t> bytes_{0, 1, 0, 0};
};

}  // namespace

common::Result<GraphPresence> GraphPresence::create(const Participant& participant, const NodeName& node,
                                                    RosGraph graph) {
  auto publications = own(dds_create_reader(participant.handle(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
                          "list the publishers");
  if (!publications) return tl::unexpected(publications.error());
  auto subscriptions =
      own(dds_create_reader(participant.handle(), DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr),
          "list the readers");
  if (!subscriptions) return tl::unexpected(subscriptions.error());
  auto writer = RawWriter::create_on(participant, "ros_discovery_info",
                                     "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_", QosProfile::kLatchedOutput);
  if (!writer) return tl::unexpected(writer.error());
  return GraphPresence(participant, node, graph, *std::move(publications), *std::move(subscriptions),
                       *std::move(writer));
}

GraphPresence::GraphPresence(Participant participant, NodeName node, RosGraph graph, Entity publications,
                             Entity subscriptions, RawWriter writer)
    : participant_(std::move(participant)),
      node_(std::move(node)),
      graph_(graph),
      publications_(std::move(publications)),
      subscriptions_(std::move(subscriptions)),
      writer_(std::move(writer)) {}

common::Result<void> GraphPresence::update() {
  if (graph_ == RosGraph::kNone) return {};
  const std::string ours = guid_of(participant_.handle());
  auto message = participant_entities_info(ours, node_, endpoints_of(ours, subscriptions_),
                                           endpoints_of(ours, publications_), graph_);
  if (message == told_) return {};
  told_ = std::move(message);
  return writer_.write(told_);
}

std::vector<std::uint8_t> participant_entities_info(const std::string& participant, const NodeName& node,
                                                    const std::vector<std::string>& readers,
                                                    const std::vector<std::string>& writers, RosGraph graph) {
  const std::size_t gid = graph == RosGraph::kUpToHumble ? kHumbleGidBytes : kGuidBytes;
  CdrWriter cdr;
  cdr.octets(participant, gid);
  cdr.number(1);  // nodes
  cdr.text(node.name_space.name());
  cdr.text(node.name);
  for (const auto* ids : {&readers, &writers}) {
    cdr.number(static_cast<std::uint32_t>(ids->size()));
    for (const std::string& id : *ids) cdr.octets(id, gid);
  }
  return std::move(cdr).bytes();
}

}  // namespace slamfuse::idl
