// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "common/error.hpp"
#include "idl/security.hpp"

namespace slamfuse::idl {

/// How far a participant's messages may go.
enum class Network {
  kLoopback,  ///< this machine only
  kAll,       ///< what CYCLONEDDS_URI says, else the first network that can multicast
};

/// Which participants this one meets.
struct DomainSettings {
  std::uint32_t id = 0;        ///< DDS domain, 0 .. kMaxDomainId
  bool loopback_only = false;  ///< talk to this machine only; also works where loopback is the only network
  std::optional<Enclave> enclave = std::nullopt;  ///< whose identity and permissions it has; none: no security
};

/// Largest domain whose ports (7400 + 250 id + offsets) fit in 16 bits.
inline constexpr std::uint32_t kMaxDomainId = 232;

/// The settings by the environment of ROS 2 nodes: ROS_DOMAIN_ID (0 when unset). The environment can narrow the network
/// and not widen it: loopback also when ROS_LOCALHOST_ONLY is 1 or ROS_AUTOMATIC_DISCOVERY_RANGE is LOCALHOST. With
/// ROS_SECURITY_ENABLE=true the enclave ROS_SECURITY_ENCLAVE_OVERRIDE (/slamfuse when unset) of ROS_SECURITY_KEYSTORE,
/// always enforced. Errors (kInvalidInput): a ROS_DOMAIN_ID that is no number in 0 .. 232, no keystore, what
/// find_enclave() misses.
common::Result<DomainSettings> domain_from_environment(Network network);

}  // namespace slamfuse::idl
