// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "common/error.hpp"

namespace slamfuse::idl {

/// Which participants this one meets.
struct DomainSettings {
  std::uint32_t id = 0;        ///< DDS domain, 0 .. kMaxDomainId
  bool loopback_only = false;  ///< talk to this machine only; also works where loopback is the only network
};

/// Largest domain whose ports (7400 + 250 id + offsets) fit in 16 bits.
inline constexpr std::uint32_t kMaxDomainId = 232;

/// The settings ROS 2 nodes would use: ROS_DOMAIN_ID (0 when unset), and loopback only when ROS_LOCALHOST_ONLY is 1 or
/// ROS_AUTOMATIC_DISCOVERY_RANGE is LOCALHOST. Error (kInvalidInput): a ROS_DOMAIN_ID that is no number in 0 .. 232.
common::Result<DomainSettings> domain_from_environment();

}  // namespace slamfuse::idl
