// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/error.hpp"
#include "service/dds_options.hpp"

namespace slamfuse::service {

/// What `slamfuse call` was asked for.
struct CallRequest {
  std::string service;   ///< "save_map", "load_map", "set_mode", "align_now" or "reinitialize_global_localization"
  std::string argument;  ///< load_map: the path; set_mode: the mode; else empty
  DdsOptions dds;        ///< network and namespace of the `serve` that is asked
};

/// Asks a service of a running `serve`, as `ros2 service call` would where ROS is installed. Gives its answer in words.
/// Errors: no such service, or an argument missing or in excess (kUsage), no `serve` is found, it does not answer or
/// could not do it (kFailed).
common::Result<std::string> run_call(const CallRequest& request);

}  // namespace slamfuse::service
