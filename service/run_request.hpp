// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/recording.hpp"
#include "service/configuration.hpp"

namespace slamfuse::service {

/// What the laser half does.
enum class RunMode {
  kSlam,          ///< makes a map
  kLocalization,  ///< finds itself in a finished one, which does not change
};

/// What `slamfuse run` was asked for.
struct RunRequest {
  std::filesystem::path recording;
  common::RecordingOptions recording_options;
  std::filesystem::path out;
  Configuration configuration;
  RunMode mode = RunMode::kSlam;
  std::optional<std::filesystem::path> map;  ///< to continue in (a bundle), or to localise in (read_localization_map)
  std::vector<std::string> modules;          ///< "laser", "visual"; empty: all that the recording has sensors for
  std::vector<std::string> cameras;          ///< sensor names; empty: all
  double from = 0.0;                         ///< [s] from the recording's start
  std::optional<double> to;                  ///< [s] from the recording's start
  std::map<std::string, double> arrival_delay;   ///< [s] by sensor name
  std::map<std::string, double> stamp_offset;    ///< [s] by sensor name
  std::map<std::string, double> sweep_duration;  ///< [s] by laser, see common::ReplayOptions
  int threads = 1;
  std::uint64_t seed = 1;
  bool dds = false;
  bool live = false;  ///< a live source: what comes too fast is dropped, checkpoints are taken, there is no truth
  double rate = 0.0;  ///< recording seconds in a second of wall time; 0: as fast as possible
};

}  // namespace slamfuse::service
