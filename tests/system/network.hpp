// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "idl/participant.hpp"
#include "idl/private_domain.hpp"

namespace slamfuse::system {

/// The processes of a test find each other and nobody else.
class Network {
 public:
  Network() : id_("ROS_DOMAIN_ID", "77") {}
  idl::Participant join() const { return *idl::Participant::create(domain_.settings()); }

 private:
  idl::PrivateDomain domain_;
  idl::ScopedEnvironment id_;
};

}  // namespace slamfuse::system
