// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "idl/message.hpp"
#include "idl/service_endpoint.hpp"
#include "idl/services.hpp"

namespace slamfuse::idl {

/// Asks a ROS 2 service that runs over Cyclone DDS. For one thread at a time.
template <class Service>
class ServiceClient {
 public:
  using Request = typename Service::Request;
  using Response = typename Service::Response;

  /// `name` is the ROS name without a leading slash, e.g. "slamfuse/save_map".
  static common::Result<ServiceClient> create(const Participant& participant, const std::string& name) {
    return ServiceEndpoint::create(participant, ServiceEndpoint::Side::kClient, name, descriptor<Request>(),
                                   descriptor<Response>())
        .map([](ServiceEndpoint&& endpoint) { return ServiceClient(std::move(endpoint)); });
  }

  /// Waits until a server is known on both ways; false when there is none in time.
  bool wait_for_server(std::chrono::nanoseconds timeout) const {
    using Clock = std::chrono::steady_clock;
    const auto deadline = Clock::now() + timeout;
    if (!endpoint_.writer.wait_for_reader(timeout)) return false;
    while (endpoint_.reader.matched_writers() == 0) {
      if (Clock::now() >= deadline) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
  }

  /// Sends the request and waits for its response; nothing when none came in time.
  common::Result<std::optional<Message<Response>>> call(Message<Request>& request, std::chrono::nanoseconds timeout) {
    using Clock = std::chrono::steady_clock;
    request->client_id = endpoint_.writer.instance();
    request->sequence_number = ++sequence_number_;
    if (auto sent = endpoint_.writer.write(&*request); !sent) return tl::unexpected(sent.error());
    const auto deadline = Clock::now() + timeout;
    while (true) {
      Message<Response> response;
      const auto left = std::max(Clock::duration::zero(), deadline - Clock::now());
      const auto taken = endpoint_.reader.take(&*response, left);
      if (!taken) return tl::unexpected(taken.error());
      if (!*taken) return std::optional<Message<Response>>();
      const bool ours = response->client_id == request->client_id && response->sequence_number == sequence_number_;
      if (ours) return std::optional<Message<Response>>(std::move(response));
    }
  }

 private:
  explicit ServiceClient(ServiceEndpoint endpoint) : endpoint_(std::move(endpoint)) {}
  ServiceEndpoint endpoint_;
  std::int64_t sequence_number_ = 0;
};

}  // namespace slamfuse::idl
