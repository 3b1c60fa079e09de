// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "common/error.hpp"
#include "common/recording.hpp"

namespace slamfuse::service {

/// What `slamfuse info` was asked for.
struct InfoRequest {
  std::filesystem::path path;
  common::RecordingOptions recording_options;
};

/// Says in words what is in a recording or in a map bundle (which is checked file by file). Errors (kInvalidInput):
/// neither, or damaged.
common::Result<std::string> run_info(const InfoRequest& request);

}  // namespace slamfuse::service
