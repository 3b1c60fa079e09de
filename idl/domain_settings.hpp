// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "common/error.hpp"

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
};

/// Largest domain whose ports (7400 + 250 id + offsets) fit in 16 bits.
inline constexpr std::uint32_t kMaxDomainId = 232;

/// The settings by the environment of ROS 2 nodes: ROS_DOMAIN_ID (0 when unset). The environment can narrow the network
/// and not widen it: loopback also when ROS_LOCALHOST_ONLY is 1 or ROS_AUTOMATIC_DISCOVERY_RANGE is LOCALHOST. Error
/// (kInvalidInput): a ROS_DOMAIN_ID that is no number in 0 .. 232.
common::Result<DomainSettings> domain_from_environment(Network network);

}  // namespace slamfuse::idl
