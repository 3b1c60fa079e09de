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
  common::SlamModule* module = nullptr;                    ///< not owned
  std::function<common::OccupancyGrid()> map = nullptr;    ///< a picture of its map; may be missing
  std::function<ModuleCheckpoint()> checkpoint = nullptr;  ///< all there is to save of it; may be missing
};

/// How often [recording time] things are taken out of a module; 0: never.
struct ModuleIntervals {
  common::Nanoseconds map = 0;
  common::Nanoseconds checkpoint = 0;
};

/// Drives one SLAM module: carries out commands, delivers inputs, counts and times, takes map pictures and checkpoints.
/// Used from one thread at a time.
class ModuleStage {
 public:
  ModuleStage(const PipelineModule& module, const ModuleIntervals& intervals)
      : module_(module), intervals_(intervals) {}

  common::PoseSource source() const { return module_.module->source(); }
  /// Whether a message is what the module is there for, a scan or an image, and not only a help.
  static bool is_exteroceptive(const common::SensorMessage& message);
  bool wants(const common::SensorMessage& message) const { return module_.module->wants(message); }

  /// Carries out the commands, then processes the input.
  ModuleOutput process(const NumberedMessage& input, const std::vector<common::Command>& commands);

  const ModuleCounters& counters() const { return counters_; }

 private:
  std::shared_ptr<const common::OccupancyGrid> map_if_due(common::Nanoseconds stamp);
  std::shared_ptr<const ModuleCheckpoint> checkpoint_if_due(common::Nanoseconds stamp);

  PipelineModule module_;
  ModuleIntervals intervals_;
  std::optional<common::Nanoseconds> last_map_;
  std::optional<common::Nanoseconds> last_checkpoint_;
  ModuleCounters counters_;
};

}  // namespace slamfuse::service
