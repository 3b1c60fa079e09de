// SPDX-License-Identifier: BSD-3-Clause
#include "idl/domain_settings.hpp"

#include <charconv>
#include <cstdlib>
#include <string>

namespace slamfuse::idl {
namespace {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

}  // namespace

common::Result<DomainSettings> domain_from_environment(Network network) {
  DomainSettings settings;
  const std::string id = environment("ROS_DOMAIN_ID");
  if (!id.empty()) {
    const auto [end, error] = std::from_chars(id.data(), id.data() + id.size(), settings.id);
    if (error != std::errc() || end != id.data() + id.size() || settings.id > kMaxDomainId) {
      return common::invalid_input("ROS_DOMAIN_ID is '" + id + "', allowed are whole numbers from 0 to " +
                                   std::to_string(kMaxDomainId));
    }
  }
  settings.loopback_only = network == Network::kLoopback || environment("ROS_LOCALHOST_ONLY") == "1" ||
                           environment("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST";
  if (environment("ROS_SECURITY_ENABLE") == "true") {
    const std::string keystore = environment("ROS_SECURITY_KEYSTORE");
    if (keystore.empty())
      return common::invalid_input("ROS_SECURITY_ENABLE is true, but ROS_SECURITY_KEYSTORE is not set");
    const std::string name = environment("ROS_SECURITY_ENCLAVE_OVERRIDE");
    auto enclave = find_enclave(keystore, name.empty() ? "/slamfuse" : name);
    if (!enclave) return tl::unexpected(enclave.error());
    settings.enclave = *std::move(enclave);
  }
  return settings;
}

}  // namespace slamfuse::idl
