// SPDX-License-Identifier: BSD-3-Clause
#include "idl/participant.hpp"

#include <cstdlib>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include <dds/dds.h>

#include "idl/cyclone_log.hpp"
#include "idl/qos.hpp"

namespace slamfuse::idl {
namespace {

// Linux does not mark `lo` as able to multicast, though it is; discovery needs it.
constexpr std::string_view kLoopbackConfig =
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/></Interfaces></General>"
    "</Domain></CycloneDDS>";

// CYCLONEDDS_URI, a comma-separated list of files and fragments, with ours at the end.
std::string loopback_config() {
  const char* uri = std::getenv("CYCLONEDDS_URI");
  std::string config = uri == nullptr ? std::string() : std::string(uri);
  if (!config.empty()) config += ',';
  return config += kLoopbackConfig;
}

using Domain = std::shared_ptr<const Entity>;

// A domain is configured once a process: its participants share it, the last one deletes it.
common::Result<Domain> configured_domain(std::uint32_t id) {
  static std::mutex mutex;
  static std::map<std::uint32_t, std::weak_ptr<const Entity>> domains;
  const std::lock_guard lock(mutex);
  if (Domain domain = domains[id].lock()) return domain;
  const std::string config = loopback_config();
  return own(dds_create_domain(id, config.c_str()),
             "configure domain " + std::to_string(id) + " for loopback only (no other interface may be named)")
      .map([&](Entity&& entity) {
        const Domain domain = std::make_shared<const Entity>(std::move(entity));
        domains[id] = domain;
        return domain;
      });
}

}  // namespace

struct Participant::State {
  Domain domain;  // outlives the participant: members are destroyed in reverse order
  Entity participant;
};

common::Result<Participant> Participant::create(const DomainSettings& settings) {
  capture_cyclone_log();
  Domain domain;
  if (settings.loopback_only) {
    auto configured = configured_domain(settings.id);
    if (!configured) return tl::unexpected(configured.error());
    domain = *std::move(configured);
  }
  // ROS 2 reads the security enclave from here; without it its tools do not list the participant.
  const UniqueQos qos(dds_create_qos());
  const std::string user_data = "enclave=" + (settings.enclave ? settings.enclave->name : "/") + ";";
  dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  if (settings.enclave) secure(*qos, *settings.enclave);
  return own(dds_create_participant(settings.id, qos.get(), nullptr), "join domain " + std::to_string(settings.id))
      .map([&](Entity&& entity) {
        return Participant(std::make_shared<const State>(State{std::move(domain), std::move(entity)}));
      });
}

common::Result<Participant> Participant::join(Network network) {
  return domain_from_environment(network).and_then(create);
}

Entity::Handle Participant::handle() const { return state_->participant.handle(); }

}  // namespace slamfuse::idl
