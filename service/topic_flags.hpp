// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "common/error.hpp"
#include "service/command_request.hpp"
#include "service/shared_flags.hpp"

namespace slamfuse::service {

/// `slamfuse play`.
class PlayFlags {
 public:
  explicit PlayFlags(CLI::App& app);

  bool chosen() const { return command_->parsed(); }

  common::Result<CommandRequest> request();

 private:
  CLI::App* command_;
  PlayRequest request_;
  ConfigurationFlags configuration_;
  RecordingFlags recording_;
  std::string stamps_ = "recorded";
  std::optional<double> to_;
};

/// `slamfuse record`.
class RecordFlags {
 public:
  explicit RecordFlags(CLI::App& app);

  bool chosen() const { return command_->parsed(); }

  common::Result<CommandRequest> request();

 private:
  CLI::App* command_;
  ConfigurationFlags configuration_;
  RecordRequest request_;
  std::optional<double> duration_;
};

/// `slamfuse call`.
class CallFlags {
 public:
  explicit CallFlags(CLI::App& app);

  bool chosen() const { return command_->parsed(); }

  common::Result<CommandRequest> request();

 private:
  CLI::App* command_;
  ConfigurationFlags configuration_;
  CallRequest request_;
};

}  // namespace slamfuse::service
