// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/error.hpp"
#include "service/command_request.hpp"
#include "service/shared_flags.hpp"

namespace slamfuse::service {

/// `slamfuse align`.
class AlignFlags {
 public:
  explicit AlignFlags(CLI::App& app);

  bool chosen() const { return command_->parsed(); }

  common::Result<CommandRequest> request();

 private:
  CLI::App* command_;
  ConfigurationFlags configuration_;
  AlignRequest request_;
  std::string method_;
};

/// `slamfuse evaluate`.
class EvaluateFlags {
 public:
  explicit EvaluateFlags(CLI::App& app);

  bool chosen() const { return command_->parsed(); }

  common::Result<CommandRequest> request();

 private:
  CLI::App* command_;
  EvaluateRequest request_;
  RecordingFlags recording_;
  std::string reference_;
  std::string align_ = "se2";
  std::vector<std::string> align_as_;
  std::string relations_;
};

/// `slamfuse info`.
class InfoFlags {
 public:
  explicit InfoFlags(CLI::App& app);
  bool chosen() const { return command_->parsed(); }
  common::Result<CommandRequest> request() const;

 private:
  CLI::App* command_;
  InfoRequest request_;
  RecordingFlags recording_;
};

/// `slamfuse options`.
class OptionsFlags {
 public:
  explicit OptionsFlags(CLI::App& app);
  bool chosen() const { return command_->parsed(); }
  common::Result<CommandRequest> request() const;

 private:
  CLI::App* command_;
  ConfigurationFlags configuration_;
  std::string format_ = "yaml";
};

}  // namespace slamfuse::service
