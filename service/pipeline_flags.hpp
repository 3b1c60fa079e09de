// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/error.hpp"
#include "service/command_request.hpp"
#include "service/shared_flags.hpp"

namespace slamfuse::service {

/// What both `run` and `serve` let the user say of the pipeline.
class PipelineFlags {
 public:
  /// Adds them to `command`; `run` gets what can be read straight away.
  void add_to(CLI::App& command, RunRequest& run);
  /// Puts the rest into `run`, and with it the configuration. Error (kUsage): --mode localization without --map; and as
  /// ConfigurationFlags::read().
  common::Result<void> apply_to(RunRequest& run) const;

 private:
  ConfigurationFlags configuration_;
  std::string mode_ = "slam";
  std::optional<std::string> map_;
  std::string visual_odometry_ = "on";
};

/// `slamfuse run`.
class RunFlags {
 public:
  explicit RunFlags(CLI::App& app);

  bool chosen() const { return command_->parsed(); }

  common::Result<CommandRequest> request();

 private:
  CLI::App* command_;
  PipelineFlags pipeline_;
  RecordingFlags recording_;
  RunRequest request_;
  std::optional<double> to_;
  std::vector<std::string> arrival_delay_;
  std::vector<std::string> stamp_offset_;
  std::vector<std::string> sweep_duration_;
};

/// `slamfuse serve`.
class ServeFlags {
 public:
  explicit ServeFlags(CLI::App& app);

  bool chosen() const { return command_->parsed(); }

  common::Result<CommandRequest> request();

 private:
  CLI::App* command_;
  PipelineFlags pipeline_;
  RecordingFlags recording_;
  ServeRequest request_;
  std::vector<std::string> readout_;
};

}  // namespace slamfuse::service
