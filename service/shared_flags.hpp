// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/error.hpp"
#include "common/recording.hpp"
#include "service/configuration.hpp"

namespace slamfuse::service {

/// The flags that choose the configuration, shared by several commands.
struct ConfigurationFlags {
  std::string file;
  std::vector<std::string> settings;

  void add_to(CLI::App& command);

  common::Result<Configuration> read() const;
};

/// What the user tells of a recording, shared by several commands.
struct RecordingFlags {
  std::vector<std::string> topics;
  std::string base_frame;

  void add_to(CLI::App& command);

  common::Result<common::RecordingOptions> read() const;
};

}  // namespace slamfuse::service
