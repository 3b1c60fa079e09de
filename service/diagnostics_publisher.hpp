// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "common/error.hpp"
#include "idl/participant.hpp"
#include "idl/ros_graph.hpp"
#include "service/live_source.hpp"

namespace slamfuse::service {

/// Publishes `diagnostics` every second, in a thread of its own, and tells a log when a topic becomes worse or well.
class DiagnosticsPublisher {
 public:
  /// `node` is the full name its rows bear; `source` must outlive it; `tell` is called from its thread, which also
  /// keeps `presence` up to date. Error (kFailed): DDS makes no writer.
  static common::Result<std::unique_ptr<DiagnosticsPublisher>> start(
      const idl::Participant& participant, idl::GraphPresence presence, const std::string& node,
      const LiveSource& source, const std::function<void(const std::string&)>& tell);

 private:
  DiagnosticsPublisher() = default;
  std::jthread thread_;
};

}  // namespace slamfuse::service
