// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <string>

#include "idl/domain_settings.hpp"
#include "idl/scoped_environment.hpp"

namespace slamfuse::idl {

/// A DDS domain on loopback that only this process (and its children) can enter, so that tests running side by side do
/// not hear each other: participants meet only when their discovery tags agree.
class PrivateDomain {
 public:
  PrivateDomain()
      : tag_("CYCLONEDDS_URI", ("<CycloneDDS><Domain><Discovery><Tag>slamfuse-test-" + std::to_string(getpid()) +
                                "</Tag></Discovery></Domain></CycloneDDS>")
                                   .c_str()) {}
  DomainSettings settings() const { return {kDomain, true}; }

 private:
  // A domain whose ports (7400 + 250 * 77) lie below the ephemeral ones.
  static constexpr std::uint32_t kDomain = 77;
  ScopedEnvironment tag_;
};

}  // namespace slamfuse::idl
