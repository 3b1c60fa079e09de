// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "idl/participant.hpp"
#include "idl/private_domain.hpp"

namespace slamfuse::system {

/// The processes of a test find each other and nobody else.
class Network {
 public:
  explicit Network(idl::Network network = idl::Network::kLoopback) : network_(network), id_("ROS_DOMAIN_ID", "77") {}
  idl::Participant join() const {
    idl::DomainSettings settings = domain_.settings();
    settings.loopback_only = network_ == idl::Network::kLoopback;
    return *idl::Participant::create(settings);
  }

 private:
  idl::Network network_;
  idl::PrivateDomain domain_;
  idl::ScopedEnvironment id_;
};

}  // namespace slamfuse::system
