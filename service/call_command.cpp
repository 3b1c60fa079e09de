// SPDX-License-Identifier: BSD-3-Clause
#include "service/call_command.hpp"

#include <algorithm>
#include <chrono>
#include <set>
#include <utility>

#include "idl/participant.hpp"
#include "idl/service_client.hpp"
#include "service/dds_outputs.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using common::Result;

constexpr auto kFindPatience = 5s;
constexpr auto kAnswerPatience = 150s;  // a session may have to end and another to begin

/// `fill` writes the argument into the request.
template <class Service, class Fill>
Result<std::string> call(const CallRequest& asked, const Fill& fill) {
  const auto names = namespace_of(asked.dds);
  if (!names) return tl::unexpected(names.error());
  const auto participant = idl::Participant::join(asked.dds.network);
  if (!participant) return tl::unexpected(participant.error());
  const std::string name = names->resolve("slamfuse/" + asked.service);
  auto client = idl::ServiceClient<Service>::create(*participant, name);
  if (!client) return tl::unexpected(client.error());
  if (!client->wait_for_server(kFindPatience)) {
    return common::failed(name +
                          ": nobody offers it (is `slamfuse serve` running in this domain, network and namespace?)");
  }
  idl::Message<typename Service::Request> request;
  fill(*request);
  const auto response = client->call(request, kAnswerPatience);
  if (!response) return tl::unexpected(response.error());
  if (!*response) return common::failed(name + ": no answer");
  const std::string text = idl::text_of((**response)->message);
  if (!(**response)->success) return common::failed(name + ": " + text);
  return text + "\n";
}

}  // namespace

Result<std::string> run_call(const CallRequest& request) {
  static const std::set<std::string> kWithArgument{"set_mode", "load_map"};
  static const std::set<std::string> kWithout{"save_map", "align_now", "reinitialize_global_localization"};
  const bool takes_argument = kWithArgument.contains(request.service);
  if (!takes_argument && !kWithout.contains(request.service)) {
    return common::usage_error("call " + request.service +
                               ": no such service (allowed: save_map, load_map PATH, set_mode MODE, align_now, "
                               "reinitialize_global_localization)");
  }
  if (takes_argument == request.argument.empty()) {
    return common::usage_error("call " + request.service + (takes_argument ? ": needs an argument" : ": takes none"));
  }
  if (request.service == "set_mode") {
    return call<idl::SetMode>(request, [&](auto& message) { idl::assign(message.mode, request.argument); });
  }
  if (request.service == "load_map") {
    return call<idl::LoadMap>(request, [&](auto& message) { idl::assign(message.path, request.argument); });
  }
  return call<idl::Trigger>(request, [](auto& /*message*/) {});
}

}  // namespace slamfuse::service
