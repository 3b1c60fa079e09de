// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "common/error.hpp"
#include "idl/participant.hpp"
#include "idl/untyped_reader.hpp"
#include "idl/untyped_writer.hpp"

namespace slamfuse::idl {

/// One side of a service as rmw_cyclonedds makes it: a writer and a reader on `rq/NAMERequest` and `rr/NAMEReply` that
/// carry one id in their USER_DATA.
struct ServiceEndpoint {
  enum class Side { kServer, kClient };

  static common::Result<ServiceEndpoint> create(const Participant& participant, Side side, const std::string& name,
                                                const dds_topic_descriptor& request,
                                                const dds_topic_descriptor& response);

  UntypedReader reader;
  UntypedWriter writer;
};

/// Whether the USER_DATA is that of a service's client. Only their questions can be answered: other middlewares send
/// who asks by a way that Cyclone does not show.
bool is_client(const std::string& user_data);

}  // namespace slamfuse::idl
