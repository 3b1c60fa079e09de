// SPDX-License-Identifier: BSD-3-Clause
#include "idl/participant.hpp"

#include <cstdlib>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include <dds/dds.h>
#include <fmt/format.h>

#include "idl/cyclone_log.hpp"
#include "idl/qos.hpp"

namespace slamfuse::idl {
namespace {

// Linux does not mark `lo` as able to multicast, though it is; discovery needs it.
constexpr std::string_view kLoopbackConfig =
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/></Interfaces></General>"
    "</Domain></CycloneDDS>";

// A sample is put together in memory before anybody sees it, so what a stranger may send is bounded here: the largest
// map and picture that make sense, by far.
constexpr std::string_view kSizeConfig =
    "<CycloneDDS><Domain><Internal><MaxSampleSize>128MB</MaxSampleSize></Internal></Domain></CycloneDDS>";

// A writer that ends waits so long for readers that have not acknowledged everything; by default a second each, and a
// service has a dozen writers. Who needs its last messages delivered waits for the acknowledgments itself.
constexpr std::string_view kLingerConfig =
    "<CycloneDDS><Domain><Internal><WriterLingerDuration>50ms</WriterLingerDuration></Internal></Domain></CycloneDDS>";

// A comma-separated list of files and fragments, later ones first in rank: CYCLONEDDS_URI may change our sizes and
// times, not where we are.
std::string configuration(bool loopback_only) {
  std::string config = fmt::format("{},{}", kSizeConfig, kLingerConfig);
  if (const char* uri = std::getenv("CYCLONEDDS_URI"); uri != nullptr && *uri != '\0') config += "," + std::string(uri);
  if (loopback_only) config += "," + std::string(kLoopbackConfig);
  return config;
}

using Domain = std::shared_ptr<const Entity>;

// A domain is configured once a process: its participants share it, the last one deletes it.
common::Result<Domain> configured_domain(std::uint32_t id, bool loopback_only) {
  struct Configured {
    std::weak_ptr<const Entity> domain;
    bool loopback_only = false;
  };
  static std::mutex mutex;
  static std::map<std::uint32_t, Configured> domains;
  const std::lock_guard lock(mutex);
  Configured& configured = domains[id];
  if (Domain domain = configured.domain.lock()) {
    if (configured.loopback_only == loopback_only) return domain;
    return common::failed("domain " + std::to_string(id) + " is in use in this process with another network");
  }
  const std::string config = configuration(loopback_only);
  const char* const how = loopback_only ? " for loopback only (no other interface may be named)" : "";
  return own(dds_create_domain(id, config.c_str()), "configure domain " + std::to_string(id) + how)
      .map([&](Entity&& entity) {
        Domain domain = std::make_shared<const Entity>(std::move(entity));
        configured = {domain, loopback_only};
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
  auto domain = configured_domain(settings.id, settings.loopback_only);
  if (!domain) return tl::unexpected(domain.error());
  // ROS 2 reads the security enclave from here; without it its tools do not list the participant.
  const UniqueQos qos(dds_create_qos());
  const std::string user_data = "enclave=" + (settings.enclave ? settings.enclave->name : "/") + ";";
  dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  if (settings.enclave) secure(*qos, *settings.enclave);
  return own(dds_create_participant(settings.id, qos.get(), nullptr), "join domain " + std::to_string(settings.id))
      .map([&](Entity&& entity) {
        return Participant(std::make_shared<const State>(State{*std::move(domain), std::move(entity)}));
      });
}

common::Result<Participant> Participant::join(Network network) {
  return domain_from_environment(network).and_then(create);
}

Entity::Handle Participant::handle() const { return state_->participant.handle(); }

}  // namespace slamfuse::idl
