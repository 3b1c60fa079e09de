// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "idl/domain_settings.hpp"
#include "idl/publications.hpp"

namespace slamfuse::service {

/// What `slamfuse record` was asked for.
struct RecordRequest {
  std::filesystem::path out;
  std::vector<std::string> topics;  ///< with or without leading slash; empty: all that are published
  std::optional<double> duration;   ///< [s] of wall time; empty: until stopped
  idl::Network network = idl::Network::kLoopback;
};

/// Writes ROS 2 topics of any type to a bag, each message as it was received. A topic takes part from when its first
/// publisher is found; the reader asks of publishers what all that are known then offer. `tell` hears which topics are
/// recorded; `on_started` is called once interruption is worth an orderly end. `stop` is the normal end. Gives what was
/// recorded in words, and what was lost. Errors: the output (see Ros2BagWriter), DDS (kFailed).
common::Result<std::string> run_record(const RecordRequest& request,
                                       const std::function<void(const std::string&)>& tell,
                                       const std::atomic<bool>& stop, const std::function<void()>& on_started);

/// What publishers of a topic offer, in the YAML in which rosbag2 keeps it.
std::string offered_qos_profiles(const std::vector<idl::Publication>& publications);

}  // namespace slamfuse::service
