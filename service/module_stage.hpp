// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/command.hpp"
#include "common/occupancy_grid.hpp"
#include "common/slam_module.hpp"
#include "service/merge_window.hpp"
#include "service/module_counters.hpp"

namespace slamfuse::service {

/// A SLAM module in the pipeline.
struct PipelineModule {
  common::SlamModule* module = nullptr;                  ///< not owned
  std::function<common::OccupancyGrid()> map = nullptr;  ///< a picture of its map; may be missing
};

/// Drives one SLAM module: carries out commands, delivers inputs, counts and times, takes a map picture every
/// `map_interval` of recording time (0: never). Used from one thread at a time.
class ModuleStage {
 public:
  ModuleStage(const PipelineModule& module, common::Nanoseconds map_interval)
      : module_(module), map_interval_(map_interval) {}

  common::PoseSource source() const { return module_.module->source(); }
  bool wants(const common::SensorMessage& message) const { return module_.module->wants(message); }

  /// Carries out the commands, then processes the input.
  ModuleOutput process(const NumberedMessage& input, const std::vector<common::Command>& commands);

  const ModuleCounters& counters() const { return counters_; }

 private:
  std::shared_ptr<const common::OccupancyGrid> map_if_due(common::Nanoseconds stamp);

  PipelineModule module_;
  common::Nanoseconds map_interval_;
  std::optional<common::Nanoseconds> last_map_;
  ModuleCounters counters_;
};

}  // namespace slamfuse::service
