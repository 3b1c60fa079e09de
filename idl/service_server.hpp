// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "idl/message.hpp"
#include "idl/service_endpoint.hpp"
#include "idl/services.hpp"

namespace slamfuse::idl {

/// Answers a ROS 2 service for clients that run over Cyclone DDS. For one thread at a time.
template <class Service>
class ServiceServer {
 public:
  using Request = typename Service::Request;
  using Response = typename Service::Response;

  /// `name` is the ROS name without a leading slash, e.g. "slamfuse/save_map".
  static common::Result<ServiceServer> create(const Participant& participant, const std::string& name) {
    return ServiceEndpoint::create(participant, ServiceEndpoint::Side::kServer, name, descriptor<Request>(),
                                   descriptor<Response>())
        .map([](ServiceEndpoint&& endpoint) { return ServiceServer(std::move(endpoint)); });
  }

  /// The next request that can be answered, if one is there.
  common::Result<std::optional<Message<Request>>> take() {
    while (true) {
      Message<Request> request;
      const auto taken = endpoint_.reader.take(&*request, {});
      if (!taken) return tl::unexpected(taken.error());
      if (!*taken) return std::optional<Message<Request>>();
      if (is_client(endpoint_.reader.sender_user_data())) return std::optional<Message<Request>>(std::move(request));
    }
  }

  /// Sends the response to who asked.
  common::Result<void> answer(const Message<Request>& request, Message<Response>& response) {
    response->client_id = request->client_id;
    response->sequence_number = request->sequence_number;
    return endpoint_.writer.write(&*response);
  }

  /// For a WaitSet.
  const UntypedReader& reader() const { return endpoint_.reader; }

 private:
  explicit ServiceServer(ServiceEndpoint endpoint) : endpoint_(std::move(endpoint)) {}
  ServiceEndpoint endpoint_;
};

}  // namespace slamfuse::idl
