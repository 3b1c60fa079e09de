// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/command.hpp"
#include "common/occupancy_grid.hpp"
#include "common/slam_module.hpp"
#include "service/merge_window.hpp"
#include "service/module_counters.hpp"
#include "service/pipeline_requests.hpp"

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
  /// Keeps at most `most_kept` update times. `requests` (may be missing) may ask for a checkpoint before it is due.
  ModuleStage(const PipelineModule& module, const ModuleIntervals& intervals, std::size_t most_kept,
              const PipelineRequests* requests)
      : module_(module), intervals_(intervals), requests_(requests) {
    counters_.updates = ThinnedSeries<UpdateTime>(most_kept);
  }

  common::PoseSource source() const { return module_.module->source(); }
  /// Whether a message is what the module is there for (a scan, an image, a pose), and not only a help.
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
  const PipelineRequests* requests_;
  std::uint32_t checkpoints_answered_ = 0;
  ModuleCounters counters_;
};

}  // namespace slamfuse::service
